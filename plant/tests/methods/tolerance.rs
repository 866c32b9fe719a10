//! The promise of `plant.tolerance` for every step.

use crate::support::built_in;
use biped_plant::contact::{Memory, Solver};
use biped_plant::{Plant, PlantError};
use messages::scene::{Law, Method, Scene};
use messages::wire::Torques;

/// Whether a scene runs for this many steps under a tolerance.
fn run(scene: &Scene, tolerance: f64, steps: usize) -> Result<(), PlantError> {
    let mut scene = scene.clone();
    scene.plant.tolerance = tolerance;
    let mut plant = Plant::new(&scene)?.without_standing_feet();
    (0..steps).try_for_each(|_| plant.advance(&Torques::default()).map(|_| ()))
}

/// The residual of a step is that of its problem solved again; the tolerance has to allow the greatest of them.
#[test]
fn a_run_ends_at_the_first_step_that_leaves_more_than_the_tolerance() {
    for (name, steps) in [("stand0", 300), ("slide30", 300), ("rock", 300)] {
        for law in [Law::Aligned, Law::Complementarity] {
            let mut scene = built_in(name);
            (scene.plant.law, scene.plant.method) = (law, Method::SemiImplicitEuler);
            (scene.plant.dt, scene.rate) = (1e-3, 1e3);
            let mut plant = Plant::new(&scene).expect("a good scene").without_standing_feet();
            let (mut solver, mut memory) = (Solver::default(), Memory::default());
            let (mut greatest, mut at) = (0.0, 0);
            for step in 0..steps {
                plant.advance(&Torques::default()).expect("a step");
                if plant.problem().contacts > 0 {
                    let own = solver.solve(plant.problem(), law, &mut memory).own;
                    if own > greatest {
                        (greatest, at) = (own, step);
                    }
                }
            }
            println!("{name}, {law}: {greatest:e} at step {at}");
            assert!(greatest > 0.0, "{name}, {law}: nothing to ask for");
            assert_eq!(run(&scene, greatest, steps as usize), Ok(()), "{name}, {law}");
            let below = greatest.next_down();
            match run(&scene, below, steps as usize).expect_err("just below the greatest residual") {
                PlantError::Unsolved { step, law: by, residual, tolerance, problem, .. } => {
                    assert_eq!((step, by, residual, tolerance), (at, law, greatest, below), "{name}");
                    assert_eq!(problem.check(), Ok(()));
                }
                other => panic!("{name}, {law}: {other}"),
            }
        }
    }
}
