//! Claim: friction on a body that slides and turns opposes the velocity of each of its contacts, as the round cone requires.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_plant::Plant;
use messages::load::load;
use messages::wire::Torques;

/// Angular velocity about the vertical at the end of a scene from `tests/data` [rad/s].
fn turning(name: &str, settings: &[&str]) -> f64 {
    let file = format!("{}/tests/data/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
    let scene = load(&file, &settings, &[]).expect("a scene");
    let mut plant = Plant::new(&scene).expect("a plant");
    for _ in 0..(scene.duration * scene.rate).round() as usize {
        plant.advance(&Torques::default()).expect("a step");
        assert!(plant.truth().natural_map <= 1e-10 && plant.truth().fallbacks == 0, "{:?}", plant.truth());
    }
    plant.state().xdot[5]
}

/// Three legs carry a puck. Its equations of motion, integrated by the classical method of fourth order in steps of 1e-4 s, give .706702
/// rad/s after half a second.
#[test]
fn a_puck_that_slides_and_turns_is_braked_about_the_vertical() {
    for (settings, most) in [(vec![], 2e-4), (vec!["plant.dt=0.00025"], 5e-5), (vec!["plant.method=EventDriven"], 1e-6)]
    {
        let found = turning("slide-and-turn", &settings);
        println!("{settings:?}: {found}");
        assert!((found - 0.706_702).abs() < most, "{settings:?}: {found}");
    }
}

/// A fourth point .4 mm above the ground never touches, so it must not change anything.
#[test]
fn a_point_without_load_changes_nothing() {
    let found = turning("untouched-point", &[]);
    println!("{found}");
    assert!((found - 1.662_76).abs() < 5e-4, "{found}");
}
