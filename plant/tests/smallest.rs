//! Claims about the smallest sufficient model: the same answer, for less.

#![expect(clippy::expect_used, reason = "a test may panic")]

use messages::load::load;
use messages::scene::{Base, Method, Scene};
use messages::wire::Torques;
use nalgebra::Vector3;
use plant::Plant;
use plant::kinematics::{self, Pose};
use plant::smallest::smallest;
use std::time::Instant;

fn scene(name: &str) -> Scene {
    let path = format!("{}/../launch/scenes/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    load(&path, &[], &[]).expect("a good scene")
}

/// Every scene that comes without a controller.
fn scenes() -> Vec<(String, Scene)> {
    let folder = format!("{}/../launch/scenes", env!("CARGO_MANIFEST_DIR"));
    let names = |folder: &str, prefix: &str| -> Vec<String> {
        let files = std::fs::read_dir(folder).expect("the scenes").map(|file| file.expect("a file").path());
        let tomls = files.filter(|path| path.extension().is_some_and(|end| end == "toml"));
        tomls.map(|path| format!("{prefix}{}", path.file_stem().expect("a name").to_string_lossy())).collect()
    };
    let mut all = [names(&folder, ""), names(&format!("{folder}/known"), "known/")].concat();
    all.sort();
    let alone = |(_, scene): &(String, Scene)| scene.controller.is_none();
    all.into_iter().map(|name| (name.clone(), scene(&name))).filter(alone).collect()
}

/// Centre of mass and velocity of every body after a while, and the time per step [µs].
fn run(scene: &Scene) -> (Vec<Vector3<f64>>, f64) {
    let mut plant = Plant::new(scene).expect("a good scene");
    let periods = (scene.duration.min(0.6) * scene.rate) as usize;
    let mut times: Vec<f64> = (0..periods)
        .map(|_| {
            let start = Instant::now();
            plant.advance(&Torques::default()).expect("a period");
            start.elapsed().as_secs_f64()
        })
        .collect();
    times.sort_by(f64::total_cmp);
    let mut pose = Pose::new(plant.model());
    kinematics::pose(plant.model(), plant.state(), &mut pose);
    let links = plant.model().body_link.iter().map(|&link| &pose.links[link]);
    let places = links.flat_map(|link| [pose.reference + link.com, link.velocity.at(&link.com), link.velocity.angular]);
    (places.collect(), 1e6 * times[periods / 2] * scene.plant.dt * scene.rate)
}

#[test]
fn every_scene_has_the_same_answer_on_its_smallest_model() {
    for (name, full) in scenes() {
        let plan = smallest(&full).expect("a good scene");
        if plan.scene == full {
            println!("{name}: {plan}");
            continue;
        }
        let [(theirs, cost), (ours, less)] = [&full, &plan.scene].map(run);
        let error = theirs.iter().zip(&ours).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{name}: {plan}; differs by {error:.1e}, {less:.2} for {cost:.2} us a step: {:.2}", less / cost);
        assert!(error < 1e-9, "{name}: {error:e}");
    }
}

#[test]
fn each_rule_does_what_it_says() {
    let size = |name: &str| smallest(&scene(name)).expect("a good scene").size;
    let of = |name: &str| (size(name).base, size(name).dofs, size(name).contacts, size(name).directions);
    assert_eq!(of("slide"), (Base::Planar, 3, 2, 1));
    assert_eq!(of("slide30"), (Base::Quaternion, 6, 4, 2), "it slides out of the plane");
    assert_eq!(of("wheel"), (Base::Planar, 3, 8, 1));
    assert_eq!(of("free"), (Base::Quaternion, 14, 0, 2), "it tumbles, and never comes down");
    assert_eq!(of("stand0"), (Base::Planar, 11, 8, 2), "a mirror image of itself, but its ankles roll");
    assert_eq!(of("drop").1, 3);
}

#[test]
fn what_a_controller_drives_is_left_as_it_is() {
    for name in ["walk", "stamp", "stand", "walk-literal"] {
        let full = scene(name);
        assert_eq!(smallest(&full).expect("a good scene").scene, full, "{name}");
    }
}

/// Negative controls: with any of these the scene is no longer its own mirror image.
#[test]
fn a_scene_that_is_not_symmetric_keeps_its_base() {
    let breaks: [fn(&mut Scene); 7] = [
        |scene| scene.initial.velocity[1] = 1e-9,
        |scene| scene.initial.orientation_deg[2] = 1.0,
        |scene| scene.initial.angular_velocity[0] = 0.1,
        |scene| scene.bodies[0].contacts[0][1] *= 1.01,
        |scene| scene.bodies[0].com[1] = 1e-6,
        |scene| scene.plant.push_impulse[1] = 1.0,
        |scene| scene.plant.payload_kg = 1.0,
    ];
    for (k, spoil) in breaks.into_iter().enumerate() {
        let mut spoilt = scene("slide");
        spoil(&mut spoilt);
        assert_eq!(smallest(&spoilt).expect("a good scene").size.base, Base::Quaternion, "break {k}");
    }
    let mut stand = scene("stand0");
    stand.initial.joints[3] += 1e-6;
    assert_eq!(smallest(&stand).expect("a good scene").size.base, Base::Quaternion);
}

#[test]
fn the_smallest_model_is_its_own_smallest_model() {
    for (name, full) in scenes() {
        let once = smallest(&full).expect("a good scene").scene;
        assert_eq!(smallest(&once).expect("a good scene").scene, once, "{name}");
    }
}

#[test]
fn the_reference_method_agrees_too() {
    for name in ["slide", "rock", "wheel", "stand0", "drop"] {
        let mut full = scene(name);
        (full.plant.method, full.plant.dt, full.rate) = (Method::EventDriven, 0.005, 200.0);
        let small = smallest(&full).expect("a good scene").scene;
        let [(theirs, cost), (ours, less)] = [&full, &small].map(run);
        let error = theirs.iter().zip(&ours).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{name}: differs by {error:.1e}, cost {:.2}", less / cost);
        assert!(error < 1e-9, "{name}: {error:e}");
    }
}
