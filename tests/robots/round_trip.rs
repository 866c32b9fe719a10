//! Claims about what `biped export` writes: the program reads it again, whatever robot and scene it is of.

use crate::common::RobotFile;
use crate::{biped, export};
use messages::load::{SCENES, load};
use messages::robot::{DriveParameters, Robot, Sphere, Tiles, table_1};
use messages::scene::Scene;

fn loaded(name: &str, settings: &[String]) -> Scene {
    load(name, settings, SCENES).unwrap_or_else(|error| unreachable!("{error}"))
}

/// Asserts that two scenes have the same robot, to the last bit.
fn assert_same_robot(scene: &Scene, other: &Scene, what: &str) {
    let robot = |scene: &Scene| {
        let plant = &scene.plant;
        let drives = (plant.drive_inertia, plant.joint_damping, plant.torque_limit, plant.encoder_bits);
        format!("{:?} {drives:?}", scene.bodies)
    };
    assert_eq!(robot(scene), robot(other), "{what}");
}

#[test]
fn the_toml_of_every_built_in_scene_is_read_as_a_robot_or_as_a_scene() {
    let mut scenes = 0;
    for (name, _) in SCENES {
        let file = RobotFile::of("toml", &export("toml", &[name]));
        let (scene, text) = (loaded(name, &[]), std::fs::read_to_string(file.path()).expect("our own file"));
        let is_robot = text.contains("\n[drives]\n");
        let again = if is_robot { loaded("walk", &[file.setting()]) } else { loaded(file.path(), &[]) };
        assert_same_robot(&scene, &again, name);
        assert!(is_robot || scene.plant.base == again.plant.base, "{name}");
        scenes += usize::from(!is_robot);
    }
    assert!(scenes > 5 && scenes < SCENES.len() - 5, "{scenes} of {} are scenes", SCENES.len());
}

/// A biped with values by chance, many of them 0 or the default.
fn random_robot(random: &mut fastrand::Rng) -> Robot {
    let mut bodies = table_1();
    let mut some = |value: f64| if random.bool() { 0.0 } else { value * (0.5 + random.f64()) };
    for left in 0..5 {
        let (x, damping, stiffness, rest, ball) = (some(0.01), some(1.0), some(9.0), some(0.3), some(0.02));
        let (height, moment, tile) = (some(0.1), some(0.01), some(1.0));
        for (k, side) in [(left, 1.0), (8 - left, -1.0)].into_iter().take(if left == 4 { 1 } else { 2 }) {
            let body = &mut bodies[k];
            body.com[0] += x;
            body.inertia = (moment > 0.0).then_some([moment; 3]);
            body.tiles = (tile > 0.0).then_some(Tiles { first: 0.0, pitch: tile, length: 0.5 * tile });
            if ball > 0.0 && left == 0 {
                body.spheres = vec![Sphere { at: [0.0, side * ball, 0.0], radius: ball }];
            }
            if let Some(joint) = &mut body.joint {
                let mirrored = if left == 0 { 1.0 } else { side };
                (joint.damping, joint.stiffness, joint.rest) = (damping, stiffness, mirrored * rest + 0.0);
                joint.at[2] = if left == 0 { -height } else { joint.at[2] };
            }
        }
    }
    let some = |random: &mut fastrand::Rng, value| random.bool().then_some(value);
    let drives = DriveParameters {
        inertia: some(random, 0.0),
        damping: some(random, 0.25),
        torque_limit: some(random, 0.0),
        encoder_bits: random.bool().then_some(12),
    };
    Robot { name: ["", "a", "a \"b\" \\ ü"][random.usize(..3)].into(), drives, bodies }
}

#[test]
fn the_toml_of_any_biped_is_read_again_to_the_last_bit() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for _ in 0..40 {
        let file = RobotFile::new(&random_robot(&mut random));
        let again = RobotFile::of("toml", &export("toml", &["--robot", file.path()]));
        let scenes = [&file, &again].map(|file| loaded("walk", &[file.setting()]));
        assert_same_robot(&scenes[0], &scenes[1], "a biped by chance");
    }
}

/// The robot of Table 1 with a ball under each foot, lower than its sole.
fn with_balls(radius: f64) -> Robot {
    let mut bodies = table_1();
    for foot in [0, 8] {
        bodies[foot].spheres.push(Sphere { at: [0.0, 0.0, -0.05], radius });
    }
    Robot { name: String::new(), drives: DriveParameters::default(), bodies }
}

/// MuJoCo shows a site at each contact point. A ball has none, even if it is as small as the sphere of a contact point.
#[test]
fn the_mjcf_marks_contact_points_and_no_balls() {
    let sites = |robot: &Robot| {
        let file = RobotFile::new(robot);
        export("mjcf", &["walk", "--robot", file.path()]).matches("<site ").count()
    };
    assert_eq!([1e-3, 2e-3].map(|radius| sites(&with_balls(radius))), [8, 8]);
}

#[test]
fn what_a_format_cannot_say_is_told_on_standard_error() {
    let [pebbles, balls] = [1e-3, 2e-3].map(|radius| RobotFile::new(&with_balls(radius)));
    let payload = ["--set", "plant.payload_kg=2", "--set", "plant.payload_offset=[0.05, 0, 0.1]"];
    for (format, arguments, lines) in [
        ("toml", &["walk", "--set", "plant.encoder_bits=12"][..], &[][..]),
        ("urdf", &["walk", "--set", "plant.encoder_bits=12"], &["plant.encoder_bits = 12 is not written"]),
        ("toml", &[&["walk"][..], &payload].concat(), &["plant.payload_kg = 2 is not written"]),
        ("urdf", &[&["walk"][..], &payload].concat(), &["the payload gives `trunk` products of inertia"]),
        ("toml", &["walk", "--set", "plant.base=fixed"], &["plant.base = \"fixed\" is not written"]),
        ("toml", &["stand0"], &[]),
        ("urdf", &["stand0"], &["the springs in the joints of `left foot`, "]),
        ("mjcf", &["stand0"], &[]),
        ("urdf", &["walk", "--set", "plant.base=planar"], &["plant.base = \"planar\" is not written: "]),
        ("urdf", &["walk", "--set", "plant.base=virtual"], &[]),
        ("urdf", &["walk", "--set", "plant.base=fixed"], &[]),
        ("toml", &["walk", "--set", "plant.base=planar"], &["plant.base = \"planar\" is not written: "]),
        ("mjcf", &["walk", "--set", "plant.base=planar"], &[]),
        ("mjcf", &["drop", "--set", "plant.restitution=0.5"], &["plant.restitution = 0.5 is not written: "]),
        (
            "urdf",
            &["walk", "--robot", pebbles.path()],
            &["the balls of `left foot`, `right foot` with a radius of 0.001 m"],
        ),
        ("toml", &["walk", "--robot", pebbles.path()], &[]),
        ("mjcf", &["walk", "--robot", pebbles.path()], &[]),
        ("urdf", &["walk", "--robot", balls.path()], &[]),
    ] {
        let output = biped(&[&["export", format], arguments].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        let told = errors.lines().count() == lines.len()
            && errors.lines().zip(lines).all(|(line, words)| line.starts_with(words));
        assert!(output.status.success() && told, "{format} {arguments:?}: {errors}");
    }
}
