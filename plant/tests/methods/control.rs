//! Step control: how much a part of a step may miss, what is taken back, and what does not settle.

use crate::support::{distance, go, plant, tumbling};
use messages::scene::{Base, Method};
use messages::wire::Torques;
use plant::PlantError;

/// The errors of the parts of a step add up, here all one way. Each is below its tolerance, and none so far below that it was effort for
/// nothing. The first part is as long as the step, and is taken back.
#[test]
fn a_part_of_a_doubled_step_misses_little_less_than_its_tolerance() {
    let run = |method: Method, tolerance: f64| {
        let mut scene = tumbling(Base::Quaternion);
        scene.plant.tolerance_step = tolerance;
        let mut plant = plant(scene, method, 0.02);
        go(&mut plant, 1);
        plant
    };
    let exact = run(Method::EventDriven, 1e-13);
    for tolerance in [1e-6, 1e-7, 1e-8] {
        let doubled = run(Method::StepDoubling, tolerance);
        let counts = doubled.counts();
        let parts = counts.evaluations as f64 / 3.0 - counts.rejected as f64; // one whole and two halves each
        let missed = distance(&doubled, &exact) / (parts * tolerance);
        println!("{tolerance:e}: a part of {parts} misses {missed:.2} of it; {counts:?}");
        assert!((0.1..1.0).contains(&missed) && counts.rejected > 0, "{tolerance:e}: {missed}, {counts:?}");
    }
    let counts = run(Method::StepDoubling, 1e3).counts();
    assert_eq!((counts.evaluations, counts.rejected), (3, 0), "what is near enough is not taken back");
}

/// In steps of .7 s a tumbling biped's mean velocity does not settle; in steps of a millisecond it does.
#[test]
fn an_implicit_step_that_does_not_settle_ends_the_run() {
    let run = |dt: f64| {
        let mut plant = plant(tumbling(Base::Quaternion), Method::ImplicitMidpoint, dt);
        (0..20).try_for_each(|_| plant.advance(&Torques::default()).map(|_| ()))
    };
    assert!(run(1e-3).is_ok());
    let error = run(0.7).expect_err("it cannot settle");
    assert!(matches!(error, PlantError::Unsettled { .. }) && error.to_string().contains("plant.dt"), "{error}");
}

/// Inertia and drive of a joint whose sum is no number make H infinite, and one over it zero: whatever pushed, the joint would stay.
#[test]
fn inertia_beyond_all_numbers_ends_the_run() {
    let text = "[plant]\ndrive_inertia = 1e308\n[[bodies]]\nname = \"a\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"b\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
        inertia = [1e308, 1e308, 1e308]\njoint = { parent = \"a\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.1] }\n";
    let scene = messages::load::parse(text, "a test").expect("a scene");
    let ended = plant::Plant::new(&scene).and_then(|mut plant| plant.advance(&Torques::default()));
    println!("{ended:?}");
    assert!(matches!(ended, Err(PlantError::Singular { pivot, .. }) if pivot == f64::INFINITY));
}
