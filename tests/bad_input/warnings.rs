//! Claims about scenes that run, but hardly as intended: one sentence on standard error, and the run goes on.

use super::biped;

/// Runs a scene to its end. Its standard error is to have one line for each of the warnings, with these words.
fn warns(scene: &str, settings: &[&str], warnings: &[&[&str]]) {
    let settings = settings.iter().flat_map(|setting| ["--set", setting]);
    let arguments: Vec<&str> = ["run", scene, "--quiet", "--in-process"].into_iter().chain(settings).collect();
    let (code, errors) = biped(&arguments);
    assert!(code == Some(0) && errors.lines().count() == warnings.len(), "{arguments:?}: {code:?}, {errors}");
    for (line, words) in errors.lines().zip(warnings) {
        assert!(words.iter().all(|word| line.contains(word)), "{arguments:?} said {line:?}, not {words:?}");
    }
}

#[test]
fn energy_from_the_ground_that_pushes_out_a_robot_is_not_blamed_on_the_step() {
    let scene = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/inside-ground.toml");
    let inside = "10.000 mm inside the ground";
    let (pushed_out, gained) = ("which pushes it out", "the ground pushed out the robot, which started inside it");
    warns(scene, &[], &[&[inside, pushed_out], &["the run gained", gained]]);
    warns(scene, &["plant.gravity=0"], &[&[inside, "proportional to plant.gravity = 0"]]);
    warns(scene, &["plant.gravity=0", "plant.law=SpringDamper", "plant.dt=1e-4"], &[&[inside, pushed_out]]);
    // on the ground, a spin by the paper's step
    let spin = ["initial.clearance=1", "plant.gravity=0", "plant.method=SemiImplicitEuler", "plant.dt=0.01"];
    let spin = [&spin[..], &["initial.angular_velocity=[9, 30, 20]", "bodies.box.size=[0.05, 0.2, 0.45]"]].concat();
    warns(scene, &spin, &[&["the run", "plant.dt is too long for plant.method"]]);
}
