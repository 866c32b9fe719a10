//! A contact law of your own: projected Gauss-Seidel on the problems of two scenes and on a recorded one, with its natural map.
//!
//! A hundred sweeps solve a brick that slides and turns. A thousand do not solve a robot on straight legs: its feet act on each other
//! through the trunk, and a sweep changes one contact at a time. The default law solves both.
//!
//!     cargo run --release --example own_law

use messages::{load, scene::Law};
use plant::Plant;
use plant::contact::{Memory, Problem, Solver};
use std::error::Error;

const BRICK: &str = r#"
plant = { method = "SemiImplicitEuler" } # the default method prescribes the direction of a steady slip
initial = { clearance = 0.0, velocity = [0.5, 0.2, 0.0], angular_velocity = [0.0, 0.0, 1.0] }
[[bodies]]
name = "brick"
mass = 2.0
size = [0.2, 0.1, 0.06]
contacts = [[0.1, 0.05, -0.03], [0.1, -0.05, -0.03], [-0.1, 0.05, -0.03], [-0.1, -0.05, -0.03]]
"#;
const ROBOT: &str = r#" # that of Table 1 with straight legs, motors off
plant = { method = "SemiImplicitEuler", drive_inertia = 0.0 }
initial = { clearance = 0.0 }
"#;

/// An unsolved problem, as a run saves it when it ends with one. `biped run walk --set plant.law=Aligned --set plant.tolerance=1e-15` writes
/// such a file. `biped contact FILE` solves it by every law of this project.
const RECORDED: &str = include_str!("recorded.json");

/// The impulse f after `sweeps` sweeps over the contacts, v = A f + b. The rows of a contact are normal, tangent, tangent.
fn gauss_seidel(problem: &Problem, sweeps: usize) -> Vec<f64> {
    let (m, mut f) = (problem.rows(), vec![0.0; problem.rows()]);
    // an impulse that acts against the velocity of one row, as far as the inverse mass allows
    let against = |row: usize, lift: f64, inverse_mass: f64, f: &[f64]| {
        let a = &problem.delassus[row * m..][..m];
        f[row] - (problem.drift[row] + lift + a.iter().zip(f).map(|(a, f)| a * f).sum::<f64>()) / inverse_mass
    };
    for contact in (0..sweeps).flat_map(|_| 0..problem.contacts) {
        let [n, x, y] = [3 * contact, 3 * contact + 1, 3 * contact + 2];
        let inverse_mass = |row: usize| problem.delassus[row * (m + 1)]; // diagonal of A
        f[n] = against(n, problem.approach[contact], inverse_mass(n), &f).max(0.0);
        let both = inverse_mass(x) + inverse_mass(y); // the same for both, so that friction opposes the slip
        let [along, across] = [against(x, 0.0, both, &f), against(y, 0.0, both, &f)];
        let shrink = (problem.friction[contact] * f[n] / along.hypot(across).max(f64::MIN_POSITIVE)).min(1.0);
        (f[x], f[y]) = (shrink * along, shrink * across); // into the disc of radius μ f_N
    }
    f
}

/// Prints the residual of the default law, and that of this law after 1 to 1000 sweeps. Returns the first and the last.
fn compare(name: &str, problem: &Problem) -> [f64; 2] {
    let mut solver = Solver::default();
    let default = solver.solve(problem, Law::Cone, &mut Memory::default()).natural_map;
    println!("{name}: {} contacts, Cone: {default:.0e}", problem.contacts);
    let mut residual = f64::NAN;
    for sweeps in [1, 10, 100, 1000] {
        residual = solver.measure_impulse(problem, Law::Cone, &gauss_seidel(problem, sweeps)).natural_map;
        println!("{sweeps:>6} sweeps: {residual:.0e}");
    }
    [default, residual]
}

/// Tries the law on the problems of two scenes and on a recorded one.
pub fn main() -> Result<(), Box<dyn Error>> {
    for (name, scene, converges) in [("brick", BRICK, true), ("robot", ROBOT, false)] {
        let mut plant = Plant::new(&load::parse(scene, name)?)?.without_standing_feet();
        plant.step()?;
        let [default, residual] = compare(name, plant.problem());
        assert!(default < 1e-10 && (residual < 1e-10) == converges, "{name}");
    }
    let mut file: serde_json::Value = serde_json::from_str(RECORDED)?;
    let problem: Problem = serde_json::from_value(file["problem"].take())?;
    problem.check()?;
    let [default, residual] = compare("recorded", &problem);
    assert!(default < 1e-10 && residual > default, "recorded");
    Ok(())
}
