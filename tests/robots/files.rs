//! Claims about robot files.

use crate::common::{RobotFile, run, scene, shanks, similar};
use crate::shapes::{LENGTH, thighs};
use crate::{biped, export};
use messages::robot::{Body, table_1};
use messages::session::Session;
use std::process::{Command, Stdio};
use std::time::Duration;

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
fn an_exported_robot_without_a_name_is_called_like_its_scene() {
    for (scene, name) in [("walk", "biped"), ("slide", "slide")] {
        let text = biped(&["export", "urdf", scene]).stdout;
        let text = String::from_utf8_lossy(&text);
        assert!(text.contains(&format!("<robot name=\"{name}\"")), "{text}");
    }
}

/// In other programs a link `world` fixes the robot. Here `plant.base` does.
#[test]
fn a_urdf_file_that_fixes_its_robot_to_the_world_is_noted_unless_the_scene_does_so_too() {
    let mount = "<link name=\"world\"/><joint name=\"mount\" type=\"fixed\"><parent link=\"world\"/><child link=\"trunk\"/></joint></robot>";
    let file = RobotFile::of("urdf", &export("urdf", &[]).replace("</robot>", mount));
    let scene = RobotFile::of("toml", &format!("robot = {:?}\nduration = 0.1\n[controller]\n", file.path()));
    let note = "joint `mount` fixes `trunk` to the link `world`, but the robot is free to move: plant.base = \"fixed\" fixes it\n";
    for (arguments, expected) in [
        (&["walk", "--set", "duration=0.1", "--robot", file.path()][..], note),
        (&[scene.path()], note),
        (&["walk", "--set", "duration=0.1", "--robot", file.path(), "--set", "plant.base=fixed"], ""),
    ] {
        let output = biped(&[&["run", "--quiet"], arguments].concat());
        assert_eq!(String::from_utf8_lossy(&output.stderr), expected, "{arguments:?}: {}", output.status);
    }
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
    refused("toml", "\n", &["the file is empty; `biped export toml`"]);
    refused("toml", "name = \"none\"", &["missing field `bodies`"]);
    refused("toml", "bodies = []", &["at least one body"]);
    edited("urdf", "<inertial>", "<inertia1>", &["not XML"]);
    edited("urdf", "<mass value=\"1\"/>", "", &["left_foot", "no mass"]);
    edited(
        "urdf",
        "<mass value=\"1\"/>",
        "<mass value=\"2 kg\"/>",
        &["value=\"2 kg\" in the mass of link `left_foot` is not a finite number"],
    );
    edited("urdf", "effort=\"40\"", "", &["the limit of joint `left_foot_joint` has no effort"]);
    edited("urdf", "<mass value=\"1\"/>", "<mass value=\"1.1\"/>", &["mirror image", "mass"]);
    edited("urdf", "<mass value=\"1\"/>", "<mass value=\"-1\"/>", &["the mass of link `left_foot` is -1, but"]);
    edited("urdf", "<mass value=\"1\"/>", "<mass value=\"1e40\"/>", &["the mass of link `left_foot` is 1e40, but"]);
    edited("urdf", "damping=\"0\"", "damping=\"1\"", &["mirror image", "its joint.damping must be 1, not 0"]);
    refused(
        "urdf",
        &urdf.replace("radius=\"0.001\"", "radius=\"0.02\""),
        &["4 balls are no corners", "exactly 0.001 m"],
    );
    edited("toml", "at = [0.0, 0.0, -0.05]", "damping = 1.0", &["missing field `at`"]);
    edited("urdf", "ixy=\"0\"", "ixy=\"0.001\"", &["ixy of `left_foot`"]);
    edited(
        "urdf",
        "effort=\"40\"",
        "effort=\"50\"",
        &["effort differs between joints (50 of `left_foot_joint`, 40 of `left_ankle_joint`), but"],
    );
    edited("urdf", "type=\"revolute\"", "type=\"floating\"", &["left_foot_joint", "neither revolute"]);
    edited(
        "urdf",
        "xyz=\"-1 0 0\"",
        "xyz=\"0 0 1\"",
        &["the joint of `left_foot` turns about 0, 0, 1, but it must roll about x"],
    );
    let slides = "the joint of `left_foot` is prismatic, but it must be revolute and roll about x";
    edited("urdf", "type=\"revolute\"", "type=\"prismatic\"", &[slides]);
    let start = urdf.find("  <joint name=\"left_foot_joint\"").expect("the ankle");
    refused(
        "urdf",
        &(urdf[..start].to_string() + "</robot>"),
        &["9 links hang on no joint, but only the trunk must hang on none: `left_foot`, `left_ankle`, "],
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
    assert!(errors.contains("no posture reaches it; this robot reaches "), "{errors}");
    let both = RobotFile::of("toml", "robot = \"my.toml\"\nbodies = []\n");
    let errors = biped(&["run", both.path()]).stderr;
    assert!(String::from_utf8_lossy(&errors).contains("leave out one of them"));
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
