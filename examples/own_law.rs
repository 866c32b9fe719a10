//! A contact law of your own: projected Gauss-Seidel. `cargo run --release --example own_law`
//!
//! It solves a foot that slides and spins, but not a recorded step of the walk: the feet act on each other through the trunk, and a sweep
//! changes one contact at a time. The default law solves both.

use messages::{load, scene::Law};
use nalgebra::{DMatrix, DVector};
use plant::Plant;
use plant::contact::{Memory, Problem, Solver};

/// A contact problem of the walk. A run saves one if it ends with an unsolved problem: `--set plant.law=Aligned --set plant.tolerance=1e-15`.
const RECORDED: &str = include_str!("recorded.json");

/// The impulse f after `sweeps` sweeps over the contacts, v = A f + b. The rows of a contact are normal, tangent, tangent.
fn gauss_seidel(problem: &Problem, sweeps: usize) -> Vec<f64> {
    let a = DMatrix::from_row_slice(problem.rows(), problem.rows(), &problem.delassus);
    let mut f = DVector::zeros(problem.rows());
    for contact in (0..sweeps).flat_map(|_| 0..problem.contacts) {
        let n = 3 * contact;
        let velocity = |row: usize, f: &DVector<f64>| problem.drift[row] + a.column(row).dot(f); // A is symmetric
        f[n] = (f[n] - (velocity(n, &f) + problem.approach[contact]) / a[(n, n)]).max(0.0);
        let mass = 1.0 / (a[(n + 1, n + 1)] + a[(n + 2, n + 2)]); // of both tangents, so that friction opposes the slip
        let friction = [n + 1, n + 2].map(|row| f[row] - mass * velocity(row, &f));
        let size = friction[0].hypot(friction[1]).max(f64::MIN_POSITIVE);
        let part = (problem.friction[contact] * f[n] / size).min(1.0); // into the disc of radius μ f_N
        (f[n + 1], f[n + 2]) = (part * friction[0], part * friction[1]);
    }
    f.as_slice().to_vec()
}

/// Prints the residual of the default law and that of a thousand sweeps, on the first step of the foot and on the recorded problem.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plant = Plant::new(&load::built_in("spinning-foot")?)?;
    plant.step()?;
    let mut file: serde_json::Value = serde_json::from_str(RECORDED)?;
    let recorded = serde_json::from_value(file["problem"].take())?;
    for (name, problem, converges) in [("foot", plant.problem(), true), ("walk", &recorded, false)] {
        let mut solver = Solver::default();
        let default = solver.solve(problem, Law::Cone, &mut Memory::default()).natural_map;
        let own = solver.measure_impulse(problem, Law::Cone, &gauss_seidel(problem, 1000)).natural_map;
        println!("{name}: natural map {default:.0e} by default, {own:.0e} after 1000 sweeps");
        assert!(default < 1e-10 && (own < 1e-10) == converges, "{name}");
    }
    Ok(())
}
