//! Claims about the contact laws and their solver, against exact answers.

mod exact;
#[path = "../common/mechanism.rs"]
mod mechanism;
mod random;
mod residuals;

use biped_plant::contact::{Memory, Problem, Report, Solver, tangents};
use mechanism::{ContactRows, G, H, of_rows, on_body};
use messages::scene::Law;

/// The laws with a basis along the problem's own tangents; the others are in `tests/laws/`.
const PIVOTED: [Law; 4] = [Law::EnergyQp, Law::EnergyQpGap, Law::Complementarity, Law::Aligned];

/// A = KᵀH⁻¹K and b = Kᵀxdot for diagonal H; the first tangent is along the free slip.
fn assemble(law: Law, contacts: &[ContactRows], inverse_inertia: &[f64], xdot: &[f64], mu: f64) -> Problem {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut rows = Vec::new();
    for [normal, x, y] in contacts {
        let (vx, vy) = (dot(x, xdot), dot(y, xdot));
        let slip = vx.hypot(vy);
        let (c, s) = if slip > 0.0 { (vx / slip, vy / slip) } else { (1.0, 0.0) };
        let turn = |c: f64, s: f64| x.iter().zip(y).map(|(x, y)| c * x + s * y).collect::<Vec<_>>();
        rows.push(normal.clone());
        rows.push(turn(c, s));
        if tangents(law) == 2 {
            rows.push(turn(-s, c));
        }
    }
    of_rows(tangents(law), &rows, inverse_inertia, xdot, mu)
}

fn point_mass(law: Law, mass: f64, speed: f64, mu: f64) -> Problem {
    let rows = [vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]];
    assemble(law, &[rows], &[1.0 / mass; 3], &[speed, 0.0, -G * H], mu)
}

fn solve(problem: &Problem, law: Law) -> (Solver, Report) {
    let mut solver = Solver::default();
    let report = solver.solve(problem, law, &mut Memory::default());
    assert!(report.own <= 1e-10 && !report.fallback, "{law:?} {report:?}");
    (solver, report)
}

fn assert_near(what: &str, value: f64, exact: f64, tolerance: f64) {
    assert!((value - exact).abs() <= tolerance * (1.0 + exact.abs()), "{what}: {value}, not {exact}");
}
