//! A foot that has come to rest on one edge after a slip, with its other corners just above the ground.

use crate::scene;
use biped_plant::Plant;
use controller::Controller;

/// Control periods in which a push presses the robot down, its feet slip, and it comes to rest.
const SLIP: usize = 4000;
/// Control periods at rest that are observed.
const REST: usize = 2000;

/// Vertical impulses of that push [N·s]. How a foot comes to rest depends on rounding, so the claim is about all of them.
const PUSHES: [f64; 5] = [19.0, 20.0, 20.5, 21.0, 22.0];

/// Most steps are solved as standing feet, although the servos chatter. From the same state, contacts solved one by one end in the same
/// velocity.
#[test]
fn a_robot_that_rests_on_an_edge_after_a_slip_stands() {
    let mut all = Rest::default();
    for push in PUSHES {
        let rest = at_rest(push);
        println!("{push} N·s: {rest:?}");
        all.add(&rest);
    }
    println!("in all {all:?}");
    assert!(2 * all.on_an_edge > all.steps, "{} of {} steps are held on an edge", all.on_an_edge, all.steps);
    // Both have residuals of up to 1e-10, which hide forces between the wedged legs. These forces move joints by up to the square root of that.
    assert!(all.difference < 1e-7, "{:e}", all.difference);
}

/// Observations of robots at rest.
#[derive(Default, Debug)]
struct Rest {
    steps: usize,
    /// Steps solved as standing feet, with at least one corner above the ground.
    on_an_edge: usize,
    /// Linear systems solved.
    systems: u64,
    /// Greatest difference of velocities between both ways.
    difference: f64,
}

impl Rest {
    fn add(&mut self, other: &Rest) {
        self.steps += other.steps;
        self.on_an_edge += other.on_an_edge;
        self.systems += other.systems;
        self.difference = self.difference.max(other.difference);
    }
}

fn at_rest(push: f64) -> Rest {
    let push = format!("plant.push_impulse=[0,0,-{push}]");
    let scene = scene("stand", &[&push, "plant.push_time=1", "controller.nominal_inertia=diagonal"]);
    let mut plant = Plant::new(&scene).expect("a plant");
    let mut one_by_one = Plant::new(&scene).expect("a plant").without_standing_feet();
    let mut controller = Controller::new(&scene).expect("a controller");
    let mut rest = Rest::default();
    for period in 0..SLIP + REST {
        let torques = controller.tick(&plant.encoders()).expect("it stands");
        let before = plant.snapshot();
        plant.advance(&torques).expect("a step");
        if period < SLIP {
            continue;
        }
        rest.steps += 1;
        rest.systems += plant.truth().pivots;
        if plant.problem().delassus.is_empty() {
            one_by_one.restore(&before);
            one_by_one.advance(&torques).expect("a step");
            let loaded = plant.truth().contact_force.iter().skip(2).step_by(3).filter(|f| **f > 0.0).count();
            rest.on_an_edge += usize::from(loaded < plant.problem().contacts);
            let pairs = plant.state().xdot.iter().zip(&one_by_one.state().xdot);
            rest.difference = pairs.fold(rest.difference, |worst, (a, b)| worst.max((a - b).abs()));
        }
    }
    rest
}
