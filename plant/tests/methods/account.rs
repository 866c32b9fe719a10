//! Accounts: the recorded forces of the ground explain the motion.

use crate::support::{built_in, plant, run_steps, totals};
use messages::scene::Method;
use nalgebra::Vector3;

/// A foot that is thrown to the ground lands on a corner, tumbles and slides. Weight and recorded contact forces add up to its change of
/// momentum, whether a method stops a landing within a step, at its end, or by an impact between two steps.
#[test]
fn recorded_contact_forces_and_weight_account_for_the_momentum_in_every_method() {
    for method in Method::ALL {
        let mut scene = built_in("drop");
        (scene.initial.velocity, scene.initial.angular_velocity) = ([0.8, 0.3, -0.5], [1.0, 2.0, -1.0]);
        let mut plant = plant(scene, method, 1e-3);
        let before = totals(&plant);
        let (mut impulse, mut loaded) = (Vector3::zeros(), 0);
        for _ in 0..400 {
            run_steps(&mut plant, 1);
            let force = plant.truth().contact_force;
            let sum = force.chunks_exact(3).map(Vector3::from_column_slice).sum::<Vector3<f64>>();
            impulse += sum * 1e-3;
            loaded += usize::from(sum.z > 0.0);
        }
        let change = totals(&plant).linear - before.linear;
        let weight = before.mass * plant.model().gravity * 0.4;
        let missing = (change - weight - impulse).amax() / weight.norm();
        println!("{method:?}: {missing:.1e} of the weight's impulse is missing, loaded in {loaded} of 400 steps");
        assert!(missing < 1e-10 && loaded > 5, "{method:?}: {missing:e}, {loaded}");
    }
}
