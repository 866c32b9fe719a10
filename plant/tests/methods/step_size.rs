//! Step size control: error of the parts of a step, rejected parts, and steps that do not converge.

use crate::support::{built_in, distance, plant, run_steps, tumbling};
use biped_plant::PlantError;
use messages::scene::{Base, Method, Scene};
use messages::wire::Torques;

/// Error of a part at which step size control aims, over its tolerance: SAFETY to the power of 3, as the error grows with h³.
const TARGET: f64 = 0.9 * 0.9 * 0.9;

/// The errors of the parts of a step add up, here with one sign. Each is near its target; the last part is shorter than planned. If the
/// difference of one step and two half steps were taken for the error of the two, the errors would be a third of the target. The first part
/// is as long as the step, and is rejected.
#[test]
fn the_error_of_a_doubled_step_is_near_its_tolerance() {
    let run = |method: Method, tolerance: f64| {
        let mut scene = tumbling(Base::Quaternion);
        scene.plant.tolerance_step = tolerance;
        let mut plant = plant(scene, method, 0.02);
        run_steps(&mut plant, 1);
        plant
    };
    let exact = run(Method::EventDriven, 1e-13);
    for tolerance in [1e-6, 1e-7, 1e-8] {
        let doubled = run(Method::StepDoubling, tolerance);
        let counts = doubled.counts();
        let parts = counts.evaluations as f64 / 3.0 - counts.rejected as f64; // one whole and two halves each
        let missed = distance(&doubled, &exact) / (parts * tolerance);
        println!("{tolerance:e}: a part of {parts} misses {missed:.2} of it; {counts:?}");
        assert!((0.5 * TARGET..1.0).contains(&missed) && counts.rejected > 0, "{tolerance:e}: {missed}, {counts:?}");
    }
    let counts = run(Method::StepDoubling, 1e3).counts();
    assert_eq!((counts.evaluations, counts.rejected), (3, 0), "a part whose error is below its tolerance is accepted");
}

/// Every trial of a part takes the twelve stages of the method. The first trial is as long as the step: under a tolerance that it misses it
/// is rejected.
#[test]
fn the_event_driven_method_counts_the_parts_that_it_rejects() {
    let counts = |tolerance: f64| {
        let mut scene = tumbling(Base::Quaternion);
        scene.plant.tolerance_step = tolerance;
        let mut plant = plant(scene, Method::EventDriven, 0.2);
        run_steps(&mut plant, 1);
        plant.counts()
    };
    let [loose, tight] = [1e3, 1e-12].map(counts);
    println!("{loose:?}, {tight:?}");
    assert_eq!((loose.evaluations, loose.rejected), (12, 0), "one part is enough");
    assert!(tight.evaluations >= 36 && tight.rejected > 0, "the first part is too long: {tight:?}");
}

/// Steps that are not rejected are two half steps, and nothing remains of the whole step that they are compared with: no contact mode, no
/// acceleration. A body in flight, a cube that slides to a stop, and a foot that lands and stands. Nothing rolls here, because the recovery
/// of a gap depends on the whole step.
#[test]
fn doubled_steps_have_the_bits_of_half_steps() {
    for (name, scene) in
        [("flight", tumbling(Base::Quaternion)), ("slide", built_in("slide")), ("drop", built_in("drop"))]
    {
        let mut halves = plant(scene.clone(), Method::MidpointContact, 1e-3);
        let mut doubled = Scene { duration: 1.0, ..scene };
        doubled.plant.tolerance_step = 1e3;
        let mut doubled = plant(doubled, Method::StepDoubling, 2e-3);
        for step in 1..=300 {
            run_steps(&mut halves, 2);
            run_steps(&mut doubled, 1);
            assert_eq!(doubled.state(), halves.state(), "{name}, step {step}");
        }
        assert_eq!(doubled.counts().rejected, 0, "{name}");
    }
}

/// In steps of .7 s the mean velocity of a tumbling biped does not converge; in steps of a millisecond it does. `StepDoubling` shortens a part
/// that fails.
#[test]
fn an_implicit_step_that_does_not_converge_ends_the_run_or_is_shortened() {
    let run = |method: Method, dt: f64, steps: usize| {
        let mut scene = tumbling(Base::Quaternion);
        scene.plant.tolerance_step = 1e-6;
        let mut plant = plant(scene, method, dt);
        (0..steps).try_for_each(|_| plant.advance(&Torques::default()).map(|_| ())).map(|()| plant)
    };
    for method in [Method::ImplicitMidpoint, Method::MidpointContact] {
        assert!(run(method, 1e-3, 20).is_ok());
        let error = run(method, 0.7, 20).err().unwrap_or_else(|| panic!("{method:?} cannot converge"));
        assert!(matches!(error, PlantError::NotConverged { .. }) && error.to_string().contains("plant.dt"), "{error}");
    }
    let [shortened, exact] = [Method::StepDoubling, Method::EventDriven].map(|method| run(method, 0.7, 1));
    let [shortened, exact] = [shortened, exact].map(|plant| plant.unwrap_or_else(|error| panic!("{error}")));
    let missed = distance(&shortened, &exact);
    println!("misses {missed:.1e} after {:?}", shortened.counts());
    assert!(missed < 1e-3 && shortened.counts().rejected > 0, "{missed}");
}

/// If inertia and drive of a joint add up to infinity, H is infinite and its inverse zero: the joint would never move.
#[test]
fn infinite_inertia_ends_the_run() {
    let text = "[plant]\ndrive_inertia = 1e308\n[[bodies]]\nname = \"a\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"b\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
        inertia = [1e308, 1e308, 1e308]\njoint = { parent = \"a\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.1] }\n";
    let scene = messages::load::parse(text, "a test").expect("a scene");
    let ended = biped_plant::Plant::new(&scene).and_then(|mut plant| plant.advance(&Torques::default()));
    println!("{ended:?}");
    assert!(matches!(ended, Err(PlantError::Singular { pivot, .. }) if pivot == f64::INFINITY));
}
