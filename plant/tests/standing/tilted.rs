//! A foot that has come to rest on one edge after a slip, with its other corners just above the ground.

use crate::scene;
use biped_plant::Plant;
use controller::Controller;

/// Control periods in which a push presses the robot down, its feet slip, and it comes to rest.
const SLIP: usize = 4000;
/// Control periods at rest that are observed.
const REST: usize = 2000;

/// The robot costs as little as any standing robot, although its servos chatter: nearly every step is solved as standing feet. From the same
/// state, contacts solved one by one end in the same velocity.
#[test]
fn a_robot_that_rests_on_an_edge_after_a_slip_stands() {
    let scene =
        scene("stand", &["plant.push_impulse=[0,0,-20]", "plant.push_time=1", "controller.nominal_inertia=diagonal"]);
    let mut plant = Plant::new(&scene).expect("a plant");
    let mut one_by_one = Plant::new(&scene).expect("a plant").without_standing_feet();
    let mut controller = Controller::new(&scene).expect("a controller");
    let (mut held, mut tilted, mut systems, mut worst) = (0, 0, 0, 0.0_f64);
    for period in 0..SLIP + REST {
        let torques = controller.tick(&plant.encoders()).expect("it stands");
        let before = plant.snapshot();
        plant.advance(&torques).expect("a step");
        if period < SLIP {
            continue;
        }
        systems += plant.truth().pivots;
        if !plant.problem().delassus.is_empty() {
            continue;
        }
        held += 1;
        let loaded = plant.truth().contact_force.iter().skip(2).step_by(3).filter(|f| **f > 0.0).count();
        tilted += usize::from(loaded < plant.problem().contacts);
        one_by_one.restore(&before);
        one_by_one.advance(&torques).expect("a step");
        let pairs = plant.state().xdot.iter().zip(&one_by_one.state().xdot);
        worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
    }
    println!(
        "{held} of {REST} steps held, {tilted} of them on an edge; {systems} linear systems; velocities differ by {worst:.1e}"
    );
    assert!(tilted > REST / 2, "the push leaves no foot on an edge: {tilted}");
    assert!(10 * held > 9 * REST, "{held} of {REST} held");
    assert!(systems < 2 * REST as u64, "{systems} linear systems in {REST} steps");
    // both have residuals of up to 1e-10, which hide forces between the wedged legs; these move joints by up to the root of that
    assert!(worst < 1e-7, "{worst:e}");
}
