//! Recorded contact forces push, and stay within the cone of friction.

use crate::support::{built_in, run_steps};
use crate::throws::thrown;
use biped_plant::Plant;
use messages::load::parse;
use messages::scene::{Method, Scene};

/// An arm at rest on the ground: its hinge holds it sideways, so its friction is not unique.
const HINGE: &str = "[plant]\nbase = \"fixed\"\nfriction = 0.3\n[initial]\nclearance = 0.002\norientation_deg = [20.0, 0.0, 30.0]\n\
    joints = [-0.4]\n[[bodies]]\nname = \"post\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"arm\"\nmass = 1.0\n\
    size = [0.4, 0.1, 0.1]\ncom = [0.2, 0.0, 0.0]\ncontacts = [[0.4, 0.03, 0.0]]\n\
    joint = { parent = \"post\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\n";

/// Accepted residual of a force, relative to the greatest of its control period [-]: rounding of solved contact problems.
const ROUNDING: f64 = 1e-9;

/// Greatest pull, or excess of friction over its limit, of all recorded forces, relative to the greatest force of the control period; and the
/// number of forces.
fn worst(mut scene: Scene, method: Method, steps: usize) -> (f64, usize) {
    (scene.plant.method, scene.plant.dt, scene.rate) = (method, 1e-3, 1e3);
    let friction = scene.plant.friction;
    let mut plant = Plant::new(&scene).expect("a good scene");
    let (mut worst, mut loaded) = (0.0_f64, 0);
    for _ in 0..steps {
        run_steps(&mut plant, 1);
        let forces = plant.truth().contact_force;
        let size = forces.iter().fold(0.0_f64, |most, force| most.max(force.abs()));
        for force in forces.chunks_exact(3).filter(|force| force.iter().any(|part| *part != 0.0)) {
            loaded += 1;
            worst = worst.max(-force[2] / size).max((force[0].hypot(force[1]) - friction * force[2]) / size);
        }
    }
    (worst, loaded)
}

#[test]
fn recorded_forces_push_within_the_cone_of_friction_in_every_method() {
    let hinge = parse(HINGE, "a test").expect("a scene");
    let throw = thrown(&mut fastrand::Rng::with_seed(4));
    let scenes = [("hinge", hinge), ("stand10", built_in("stand10")), ("slide", built_in("slide")), ("throw", throw)];
    for (name, scene) in scenes {
        for method in Method::ALL {
            let (worst, loaded) = worst(scene.clone(), method, 500);
            println!("{name}, {method:?}: {worst:.1e} of the greatest force outside, {loaded} forces");
            assert!(worst < ROUNDING && loaded > 20, "{name}, {method:?}: {worst:e}, {loaded}");
        }
    }
}
