//! Preparation of a step before its torques are known.

use crate::support::{plant, run_steps};
use messages::scene::{Method, Scene};
use messages::wire::Torques;

#[test]
fn preparing_a_step_before_its_torques_changes_no_result() {
    for method in [Method::SemiImplicitEuler, Method::MidpointMoreau] {
        let mut scene = Scene::default();
        scene.initial.clearance = Some(0.0);
        let plants = || plant(scene.clone(), method, 1e-3);
        let (mut early, mut late, mut other) = (plants(), plants(), plants());
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        for step in 0..300 {
            early.prepare();
            let torques = Torques { torque: std::array::from_fn(|_| 10.0 * random.f64() - 5.0) };
            for plant in [&mut early, &mut late] {
                if step == 100 {
                    assert!(plant.push(4, [0.5, 0.2, 0.0], 0.01), "a body");
                }
                plant.advance(&torques).expect("a step");
            }
            assert_eq!(early.truth().hash, late.truth().hash, "{method:?} at step {step}");
            assert_eq!(early.counts(), late.counts());
            early.prepare();
            run_steps(&mut other, 1);
        }
        assert_ne!(early.truth().hash, other.truth().hash, "negative control: other torques");
    }
}
