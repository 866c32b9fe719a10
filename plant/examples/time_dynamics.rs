//! Time of each stage of the dynamics: `cargo run --release -p plant --example time_dynamics`.

use messages::scene::{Base, Scene};
use plant::composite::Composite;
use plant::factor::{Factor, PathMatrix};
use plant::kinematics::{self, Pose};
use plant::model::Model;
use plant::state::State;
use plant::{PlantError, dynamics};
use std::hint::black_box;
use std::time::Instant;

/// Median time of one call over many batches [ns].
fn median(mut stage: impl FnMut()) -> f64 {
    const CALLS: u32 = 100;
    let mut batches: Vec<f64> = (0..501)
        .map(|_| {
            let start = Instant::now();
            (0..CALLS).for_each(|_| stage());
            start.elapsed().as_secs_f64() * 1e9 / f64::from(CALLS)
        })
        .collect();
    batches.sort_by(f64::total_cmp);
    batches[batches.len() / 2]
}

fn main() -> Result<(), PlantError> {
    println!(
        "{:>12} {:>8} {:>8} {:>8} {:>8} {:>8} {:>10} {:>10} ns",
        "base", "pose", "H", "b", "factor", "solve", "(2)-(11) H", "advance"
    );
    for base in [Base::Fixed, Base::Planar, Base::Virtual, Base::Quaternion] {
        let mut scene = Scene::default();
        scene.plant.base = base;
        let model = Model::new(&scene)?;
        let mut state = State::zero(&model);
        state.x.iter_mut().zip(1..).for_each(|(x, i)| *x += 0.05 * f64::from(i));
        state.xdot.iter_mut().zip(1..).for_each(|(v, i)| *v = 0.1 * f64::from(i));
        state.advance(&model, 1e-3); // makes a quaternion a unit one
        let (mut pose, mut composite) = (Pose::new(&model), Composite::new(&model));
        let (mut h, mut b) = (PathMatrix::new(&model), vec![0.0; model.dofs()]);
        let mut factor = Factor::new(&model);
        let times = [
            median(|| kinematics::pose(&model, black_box(&state), black_box(&mut pose))),
            median(|| composite.inertia(&model, black_box(&pose), black_box(&mut h))),
            median(|| composite.bias(&model, black_box(&pose), &state.xdot, black_box(&mut b))),
            median(|| factor.factorize(&model, black_box(&h)).unwrap_or_default()),
            median(|| factor.solve(&model, black_box(&mut b))),
        ];
        let reference = median(|| drop(black_box(dynamics::inertia(&model, black_box(&pose)))));
        let advance = median(|| black_box(&mut state).advance(&model, 1e-9));
        print!("{:>12}", format!("{base:?}").to_lowercase());
        times.iter().for_each(|time| print!(" {time:8.0}"));
        println!(" {reference:10.0} {advance:10.0}");
    }
    Ok(())
}
