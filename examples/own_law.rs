//! A contact law of your own: projected Gauss-Seidel. `cargo run --release --example own_law`
//!
//! It solves a foot that slides and spins, but not a recorded step of the walk: the feet act on each other through the trunk, and a sweep
//! changes one contact at a time. The default law solves both.

use messages::{load, scene::Law};
use plant::Plant;
use plant::contact::{Memory, Problem, Solver};

/// A contact problem of the walk. A run saves one if it ends with an unsolved problem: `--set plant.law=Aligned --set plant.tolerance=1e-15`.
const RECORDED: &str = include_str!("recorded.json");

/// The impulse f after `sweeps` sweeps over the contacts, v = A f + b. The rows of a contact are normal, tangent, tangent.
fn gauss_seidel(problem: &Problem, sweeps: usize) -> Vec<f64> {
    let (m, mut f) = (problem.rows(), vec![0.0; problem.rows()]);
    let velocity = |row: usize, f: &[f64]| {
        problem.drift[row] + problem.delassus[row * m..][..m].iter().zip(f).map(|(a, f)| a * f).sum::<f64>()
    };
    let inverse_mass = |row: usize| problem.delassus[row * (m + 1)]; // diagonal of A
    for contact in (0..sweeps).flat_map(|_| 0..problem.contacts) {
        let [n, x, y] = [3 * contact, 3 * contact + 1, 3 * contact + 2];
        f[n] = (f[n] - (velocity(n, &f) + problem.approach[contact]) / inverse_mass(n)).max(0.0);
        let mass = 1.0 / (inverse_mass(x) + inverse_mass(y)); // the same along both tangents, so that friction opposes the slip
        let friction = [f[x] - mass * velocity(x, &f), f[y] - mass * velocity(y, &f)];
        let size = friction[0].hypot(friction[1]).max(f64::MIN_POSITIVE);
        let part = (problem.friction[contact] * f[n] / size).min(1.0); // into the disc of radius μ f_N
        (f[x], f[y]) = (part * friction[0], part * friction[1]);
    }
    f
}

/// Prints the residual of the default law and that of a thousand sweeps, on the first step of the foot and on the recorded problem.
pub fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut plant = Plant::new(&load::built_in("spinning-foot")?)?;
    plant.step()?;
    let recorded = serde_json::from_value(serde_json::from_str::<serde_json::Value>(RECORDED)?["problem"].take())?;
    for (name, problem, converges) in [("foot", plant.problem(), true), ("walk", &recorded, false)] {
        let mut solver = Solver::default();
        let default = solver.solve(problem, Law::Cone, &mut Memory::default()).natural_map;
        let own = solver.measure_impulse(problem, Law::Cone, &gauss_seidel(problem, 1000)).natural_map;
        println!(
            "{name}, {} contacts: natural map {default:.0e} by default, {own:.0e} after 1000 sweeps",
            problem.contacts
        );
        assert!(default < 1e-10 && (own < 1e-10) == converges, "{name}");
    }
    Ok(())
}
