//! Claims about robots in files: the paper's robot survives export and import bit for bit, robots of another size walk as dynamic similarity
//! predicts, robots of another shape walk, and a file that is no biped is refused with a sentence.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{RobotFile, run, run_two, scene, shanks, similar};
use controller::Controller;
use messages::robot::{Body, DriveParameters, Robot, Scale, table_1};
use messages::scene::Scene;
use messages::session::Session;
use plant::Plant;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

const LENGTH: f64 = 1.5;

fn biped(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).output().expect("the program starts")
}

fn export(format: &str, arguments: &[&str]) -> String {
    let output = biped(&[&["export", format], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("plain text")
}

#[test]
fn a_robot_that_is_exported_and_read_again_is_the_same_to_the_last_bit() {
    let plain = run("walk", &["duration=4"]);
    let odd = RobotFile::new(&similar(1.0 / 3.0));
    for robot in [&[][..], &["--robot", odd.path()]] {
        for format in ["toml", "urdf"] {
            let text = export(format, robot);
            let file = RobotFile::of(format, &text);
            assert_eq!(export(format, &["--robot", file.path()]), text);
            if robot.is_empty() {
                assert_eq!(run("walk", &[&file.setting(), "duration=4"]).hash(), plain.hash(), "as {format}");
            }
        }
    }
}

#[test]
fn a_robot_one_and_a_half_times_as_large_walks_as_dynamic_similarity_says() {
    let file = RobotFile::new(&similar(LENGTH));
    let (small, large) = (run("walk", &[]), run_two("walk", &[&file.setting()]));
    let time = LENGTH.sqrt();
    let near = |value: f64, share: f64| value * (1.0 - share)..=value * (1.0 + share);
    large.assert_ranges(&[
        ("speed_mps", near(small.number("speed_mps") * time, 0.01)),
        ("period_s", near(small.number("period_s") * time, 1e-3)),
        ("x2_min_m", near(small.number("x2_min_m") * LENGTH, 0.01)),
        ("foot_tilt_max_deg", 0.0..=0.2),
        ("fallbacks", 0.0..=0.0),
    ]);
}

/// Joint angles in each control period.
fn angles(scene: &Scene) -> Vec<[f64; 8]> {
    let mut plant = Plant::new(scene).expect("a good scene");
    let mut controller = Controller::new(scene).expect("a controller");
    let mut encoders = plant.encoders();
    let periods = (scene.duration * scene.rate).round() as usize;
    let period = |_| {
        let torques = controller.tick(&encoders).expect("a task that can be resolved");
        encoders = plant.advance(&torques).expect("a period");
        plant.truth().angle
    };
    (0..periods).map(period).collect()
}

/// Largest difference between the joint angles of the robot of Table 1 and those of another robot at the same scaled time: over the first
/// 2.5 s, which have four steps, and over the whole walk [rad].
fn difference(robot: &Robot, settings: &[&str]) -> [f64; 2] {
    let file = RobotFile::new(robot);
    let time = Scale::between(&table_1(), &robot.bodies).time();
    let clocks =
        [format!("rate={}", 1000.0 / time), format!("plant.dt={}", time / 1000.0), format!("duration={}", 14.0 * time)];
    let own = [&[file.setting()], &clocks[..]].concat();
    let settings: Vec<&str> = own.iter().map(String::as_str).chain(settings.iter().copied()).collect();
    let (small, large) = (angles(&scene("walk", &[])), angles(&scene("walk", &settings)));
    assert_eq!(small.len(), large.len());
    [2500, small.len()].map(|count| {
        let pairs = small.iter().take(count).flatten().zip(large.iter().flatten());
        pairs.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
    })
}

/// A length ratio of 4 gives a time ratio of 2, so scaling causes no rounding and every phase starts at the same scaled control period. The two
/// walks are equal bit for bit for 1.1 s. Then absolute tolerances of the contact solver cause a small difference, which grows until a foot
/// lands one period earlier or later. After that, the observer keeps the two walks close together.
#[test]
fn a_similar_robot_moves_like_the_small_one_in_scaled_time() {
    let same = difference(&similar(4.0), &[]);
    let lighter = difference(&similar(4.0), &["plant.drive_inertia=80"]);
    println!("joint angles differ by {same:?} rad at most; {lighter:?} rad with drives a little lighter");
    assert!(same[0] < 1e-8 && same[1] < 5e-3, "{same:?} rad");
    assert!(lighter[0] > 1e5 * same[0] && lighter[1] > 2.0 * same[1], "{lighter:?} beside {same:?} rad");
}

#[test]
fn a_robot_with_shanks_a_fifth_longer_walks() {
    let robot = shanks(1.2);
    let file = RobotFile::new(&robot);
    let time = Scale::between(&table_1(), &robot.bodies).time();
    run("walk", &[&file.setting()]).assert_ranges(&[
        ("speed_mps", 0.2 * time..=0.21 * time),
        ("period_s", 0.599 * time..=0.601 * time),
        ("yaw_deg", -0.1..=0.1),
        ("foot_tilt_max_deg", 0.0..=0.2),
    ]);
}

#[test]
fn a_scene_that_names_a_robot_gets_its_missing_values_from_it() {
    let robot = RobotFile::new(&shanks(1.2));
    let name = std::path::Path::new(robot.path()).file_name().expect("a name").to_string_lossy();
    let text = format!("robot = {name:?}\nduration = 4.0\n[plant]\ndt = 0.001\n[controller]\nspeed = 0.2\n");
    let scene = RobotFile::of("toml", &text);
    run(scene.path(), &[]).assert_ranges(&[("distance_m", 0.15..=0.35), ("steps", 6.0..=9.0)]);
}

#[test]
fn plant_and_controller_with_different_robots_refuse_each_other() {
    let (file, session) = (RobotFile::new(&similar(LENGTH)), format!("robots-{}", std::process::id()));
    let start = |arguments: &[&str]| {
        let mut program = Command::new(env!("CARGO_BIN_EXE_biped"));
        program.args(arguments).args(["walk", "--session", &session]).stderr(Stdio::piped()).spawn().expect("it starts")
    };
    let mut roles = [start(&["plant"]), start(&["controller", "--robot", file.path()])];
    let late = loop {
        std::thread::sleep(Duration::from_millis(20));
        if let Some(late) = roles.iter_mut().position(|role| role.try_wait().expect("our own child").is_some()) {
            break late;
        }
    };
    roles[1 - late].kill().expect("our own child");
    let [plant, controller] = roles.map(|role| role.wait_with_output().expect("our own child"));
    let refused = [plant, controller].into_iter().nth(late).expect("one of two");
    let errors = String::from_utf8_lossy(&refused.stderr);
    assert_eq!(refused.status.code(), Some(5), "{errors}");
    assert!(errors.contains("model") && errors.contains("same program, scene and options"), "{errors}");
    Session::named(&session).expect("a good name").remove_files();
}

#[test]
fn a_robot_file_that_is_no_biped_is_refused_with_a_sentence() {
    let refused = |kind: &str, text: &str, words: &[&str]| {
        let file = RobotFile::of(kind, text);
        let output = biped(&["run", "walk", "--robot", file.path()]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{words:?}: {errors}");
        for word in words {
            assert!(errors.contains(word) && errors.contains(file.path()), "{errors} does not say {word}");
        }
        assert!(!errors.contains("panicked"), "{errors}");
    };
    let (toml, urdf) = (export("toml", &[]), export("urdf", &[]));
    let edited = |kind: &str, from: &str, to: &str, words: &[&str]| {
        let text = if kind == "toml" { &toml } else { &urdf };
        assert!(text.contains(from), "the test is out of date: no {from}");
        refused(kind, &text.replacen(from, to, 1), words);
    };
    edited("toml", "mass = 1.0", "mass = -1.0", &["bodies.left foot.mass = -1", "greater than 0"]);
    edited("toml", "mass = 1.0", "mass = nan", &["bodies.0.mass = NaN", "finite"]);
    edited("toml", "mass = 1.0", "mas = 1.0", &["^", "unknown field `mas`", "`mass`"]);
    edited("toml", "inertia = 0.1", "inertia = -0.1", &["drives.inertia", "negative"]);
    edited("toml", "[0.0, -1.0, 0.0]", "[0.0, 0.0, 1.0]", &["`left ankle`", "must pitch about y"]);
    edited("toml", "parent = \"left ankle\"", "parent = \"tail\"", &["bodies.left foot.joint.parent", "another body"]);
    edited("toml", "mass = 3.0", "mass = 3.0\ncom = [0.0, 0.1, 0.0]", &["`trunk`", "y = 0"]);
    edited(
        "toml",
        "mass = 1.0",
        "mass = 1.0\ninertia = [1.0, 1.0, 3.0]",
        &["bodies.left foot.inertia", "at most the sum"],
    );
    refused("toml", "", &["missing field `bodies`"]);
    refused("toml", "bodies = []", &["at least one body"]);
    edited("urdf", "<inertial>", "<inertia1>", &["not XML"]);
    edited("urdf", "<mass value=\"1\"/>", "", &["left_foot", "no mass"]);
    edited("urdf", "<mass value=\"1\"/>", "<mass value=\"one\"/>", &["\"one\"", "not a number"]);
    edited("urdf", "<mass value=\"1\"/>", "<mass value=\"1.1\"/>", &["mirror image", "mass"]);
    edited("urdf", "ixy=\"0\"", "ixy=\"0.001\"", &["ixy of `left_foot`"]);
    edited("urdf", "effort=\"40\"", "effort=\"50\"", &["effort differs"]);
    edited("urdf", "type=\"revolute\"", "type=\"floating\"", &["left_foot_joint", "neither revolute"]);
    edited("urdf", "xyz=\"-1 0 0\"", "xyz=\"0 0 1\"", &["must roll about x"]);
    let start = urdf.find("  <joint name=\"left_foot_joint\"").expect("the ankle");
    refused(
        "urdf",
        &(urdf[..start].to_string() + "</robot>"),
        &["exactly one body, the base, must be without a joint"],
    );

    let file = RobotFile::of("toml", &toml);
    for (arguments, words) in [
        (&["walk", "--robot", "missing.urdf"][..], &["missing.urdf", "no such file"][..]),
        (&["rock", "--robot", file.path()], &["only a biped without springs"]),
        (&["stand0", "--robot", file.path()], &["only a biped without springs"]),
    ] {
        let output = biped(&[&["run"], arguments].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        words.iter().for_each(|word| assert!(errors.contains(word), "{errors} does not say {word}"));
    }
    let low = biped(&["run", "walk", "--in-process", "--robot", RobotFile::new(&thighs(0.3)).path()]);
    let errors = String::from_utf8_lossy(&low.stderr);
    assert_eq!(low.status.code(), Some(2), "{errors}");
    assert!(errors.contains("no posture reaches it"), "{errors}");
    let both = RobotFile::of("toml", "robot = \"my.toml\"\nbodies = []\n");
    let errors = biped(&["run", both.path()]).stderr;
    assert!(String::from_utf8_lossy(&errors).contains("leave out one of them"));
}

/// The robot of Table 1 with changes to some bodies.
fn changed(bodies: &[usize], change: impl Fn(&mut Body)) -> Robot {
    let mut robot = similar(1.0);
    bodies.iter().for_each(|&body| change(&mut robot.bodies[body]));
    robot
}

fn thighs(length: f64) -> Robot {
    let mut robot = changed(&[3, 5], |thigh| (thigh.size[2], thigh.com[2]) = (0.2 * length, -0.1 * length));
    for shank in [2, 6] {
        robot.bodies[shank].joint.as_mut().expect("a knee").at[2] = -0.2 * length;
    }
    robot
}

fn hips(width: f64) -> Robot {
    changed(&[3, 5], |thigh| thigh.joint.as_mut().expect("a hip").at[1] *= width)
}

fn soles(length: f64) -> Robot {
    changed(&[0, 8], |foot| foot.contacts.iter_mut().for_each(|corner| corner[0] *= length))
}

fn trunk(mass: f64) -> Robot {
    changed(&[4], |trunk| trunk.mass *= mass)
}

fn trunk_on_weak_drives(mass: f64) -> Robot {
    let drives = DriveParameters { inertia: Some(0.1), torque_limit: Some(40.0), ..DriveParameters::default() };
    Robot { drives, ..trunk(mass) }
}

fn legs(mass: f64) -> Robot {
    changed(&[2, 3, 5, 6], |bone| bone.mass *= mass)
}

/// The limits in the table of docs/SCENES.md.
#[test]
fn robots_walk_within_a_documented_distance_from_table_1() {
    type Kind = (&'static str, fn(f64) -> Robot, &'static [f64], &'static [f64]);
    let kinds: [Kind; 8] = [
        ("all lengths", similar, &[0.03, 0.1, 0.5, 2.0, 10.0, 50.0], &[0.01]),
        ("length of the shanks", shanks, &[0.25, 0.35, 0.5, 1.2, 2.0, 3.0], &[4.0]),
        ("length of the thighs", thighs, &[0.4, 0.5, 0.8, 1.2, 2.0, 3.0], &[]),
        ("distance of the hips", hips, &[0.2, 0.35, 0.5, 0.7, 1.5, 2.0, 3.0, 5.0], &[]),
        ("length of the soles", soles, &[0.7, 0.8, 2.0, 3.0], &[0.35]),
        ("mass of the trunk", trunk, &[0.1, 0.5, 1.5, 2.0, 3.0, 4.0], &[8.0, 10.0]),
        ("the same, drives as they are", trunk_on_weak_drives, &[2.5, 5.0, 7.0], &[]),
        ("mass of thighs and shanks", legs, &[0.1, 0.5, 2.0, 8.0], &[]),
    ];
    let mut wrong = Vec::new();
    for (what, robot, walk, fall) in kinds {
        println!("{what:<28} walks at {walk:?} times Table 1's, falls at {fall:?}");
        for (factors, falls) in [(walk, false), (fall, true)] {
            for &factor in factors {
                let fell = run("walk", &[&RobotFile::new(&robot(factor)).setting()]).fell();
                if fell != falls {
                    wrong.push(format!("{what} times {factor}: falls: {fell}"));
                }
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong:#?}");
}

fn numbers(text: &str) -> Vec<f64> {
    text.split_whitespace().map(|word| word.parse().expect("a number")).collect()
}

/// The robots of `cargo bench -- --peers` are the paper's: each number agrees to rounding, only the left joints turn the other way.
#[test]
fn the_robots_of_the_benchmark_are_that_of_table_1() {
    let given = table_1();
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/bench/peers/biped8");
    let read = scene("free", &[&format!("robot={folder}.urdf")]);
    let near = |(a, b): (&f64, &f64)| (a - b).abs() <= 1e-15 * a.abs();
    let same = |a: &[f64], b: &[f64]| a.len() == b.len() && a.iter().zip(b).all(near);
    assert_eq!((read.bodies.len(), read.plant.drive_inertia), (given.len(), 0.0));
    for (read, given) in read.bodies.iter().zip(&given) {
        let plain = |body: &Body| Body { inertia: None, ..body.clone() };
        assert_eq!(plain(read), plain(given));
        assert!(same(&read.moments(), &given.moments()), "{}: {:?} {:?}", given.name, read.moments(), given.moments());
    }
    let text = std::fs::read_to_string(format!("{folder}.xml")).expect("MJCF");
    let document = roxmltree::Document::parse(&text).expect("XML");
    let mut count = 0;
    for node in document.descendants().filter(|node| node.has_tag_name("body")) {
        count += 1;
        let name = node.attribute("name").expect("a name").replace("l_", "left ").replace("r_", "right ");
        let name = if name == "body" { "trunk".into() } else { name };
        let given = given.iter().find(|body| body.name == name).expect("a body of Table 1");
        let child = |tag: &str| node.children().find(|child| child.has_tag_name(tag));
        let list = |node: roxmltree::Node, key: &str| numbers(node.attribute(key).unwrap_or_default());
        let inertial = child("inertial").expect("an inertial");
        assert!(same(&[given.mass], &list(inertial, "mass")) && same(&given.com, &list(inertial, "pos")), "{name}");
        assert!(same(&given.moments(), &list(inertial, "diaginertia")), "{name}: {inertial:?}");
        if let Some(joint) = &given.joint {
            let axis = joint.axis.map(f64::abs);
            assert!(
                same(&joint.at, &list(node, "pos")) && same(&axis, &list(child("joint").expect("a joint"), "axis")),
                "{name}"
            );
        }
        let sole: Vec<f64> = child("geom").map(|geom| list(geom, "size")).unwrap_or_default();
        let half: Vec<f64> =
            if given.contacts.is_empty() { vec![] } else { given.size.map(|side| 0.5 * side).to_vec() };
        assert!(same(&half, &sole), "{name}: {sole:?}");
    }
    assert_eq!(count, given.len());
}
