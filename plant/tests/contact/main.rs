//! Claims about the contact laws and their solver, against exact answers.

mod exact;
mod random;

use messages::scene::Law;
use plant::contact::{Memory, Problem, Report, Solver, tangents};

const G: f64 = 9.81;
const H: f64 = 1e-3;
/// The laws that are solved by pivoting along the problem's own tangents; the others are in `tests/laws/`.
const PIVOTED: [Law; 4] = [Law::EnergyQp, Law::EnergyQpGap, Law::Complementarity, Law::Aligned];
/// One row of K^T: normal, then the tangents x and y of the world.
type Rows = [Vec<f64>; 3];

/// A = K^T H^-1 K and b = K^T xdot for diagonal H; the first tangent turned along the free slip.
fn assemble(law: Law, contacts: &[Rows], inverse_inertia: &[f64], xdot: &[f64], mu: f64) -> Problem {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut problem = Problem::default();
    problem.reset(contacts.len(), tangents(law));
    problem.friction.fill(mu);
    let mut rows = Vec::new();
    for [normal, x, y] in contacts {
        let (vx, vy) = (dot(x, xdot), dot(y, xdot));
        let slip = vx.hypot(vy);
        let (c, s) = if slip > 0.0 { (vx / slip, vy / slip) } else { (1.0, 0.0) };
        let turn = |c: f64, s: f64| x.iter().zip(y).map(|(x, y)| c * x + s * y).collect::<Vec<_>>();
        rows.push(normal.clone());
        rows.push(turn(c, s));
        if problem.tangents == 2 {
            rows.push(turn(-s, c));
        }
    }
    let m = problem.rows();
    for (i, row) in rows.iter().enumerate() {
        let weighted: Vec<f64> = row.iter().zip(inverse_inertia).map(|(k, h)| k * h).collect();
        for (j, other) in rows.iter().enumerate() {
            problem.delassus[i * m + j] = dot(&weighted, other);
        }
        problem.drift[i] = dot(row, xdot);
    }
    problem
}

/// A point r fixed to a rigid body with coordinates (v, omega) at its centre of mass.
fn on_body([x, y, z]: [f64; 3]) -> Rows {
    [vec![0., 0., 1., y, -x, 0.], vec![1., 0., 0., 0., z, -y], vec![0., 1., 0., -z, 0., x]]
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
