//! Mechanisms for the claims about contact laws.

use super::mechanism::of_rows;
pub use super::mechanism::{ContactRows, G, H, on_body};
use biped_plant::contact::{Memory, Problem, Report, Solver};
use messages::scene::Law;

/// A = KᵀH⁻¹K and b = Kᵀxdot for diagonal H, with `tangents` along fixed axes.
pub fn assemble(tangents: usize, contacts: &[ContactRows], inverse_inertia: &[f64], xdot: &[f64], mu: f64) -> Problem {
    let rows: Vec<Vec<f64>> = contacts.iter().flat_map(|rows| rows[..1 + tangents].to_vec()).collect();
    of_rows(tangents, &rows, inverse_inertia, xdot, mu)
}

/// A point mass on the ground with this free velocity (x, y, z).
pub fn point_mass(mass: f64, velocity: [f64; 3], mu: f64) -> Problem {
    assemble(2, &[[vec![0., 0., 1.], vec![1., 0., 0.], vec![0., 1., 0.]]], &[1.0 / mass; 3], &velocity, mu)
}

/// Scene 15: the ground carries a light mass of 1 kg that carries one `ratio` times as heavy.
pub fn heavy_on_light(ratio: f64) -> Problem {
    let ground = [vec![1., 0., 0., 0.], vec![0., 0., 1., 0.], vec![0.; 4]];
    let between = [vec![-1., 1., 0., 0.], vec![0., 0., -1., 1.], vec![0.; 4]];
    assemble(2, &[ground, between], &[1., 1. / ratio, 1., 1. / ratio], &[-G * H, -G * H, 0., 0.], 0.5)
}

/// A chain of bodies on a free base, with a hinge at the end of each, and contact points anywhere on them.
///
/// H is drawn as diagonal; K is that of the chain.
pub fn chain(seed: u64, tangents: usize, spread: f64, mu: f64) -> Problem {
    let mut random = fastrand::Rng::with_seed(seed);
    let mut vector = |size: f64| [0; 3].map(|_| size * (2.0 * random.f64() - 1.0));
    let cross = |[a, b, c]: [f64; 3], [x, y, z]: [f64; 3]| [b * z - c * y, c * x - a * z, a * y - b * x];
    // Hinge j joins bodies j and j + 1.
    let mut hinges = Vec::new();
    let mut at = [0.0; 3];
    for _ in 0..6 {
        let (step, axis) = (vector(0.3), vector(1.0));
        let length = axis.iter().map(|a| a * a).sum::<f64>().sqrt();
        at = [0, 1, 2].map(|k| at[k] + step[k]);
        hinges.push((at, axis.map(|a| a / length)));
    }
    let points: Vec<[f64; 3]> = (0..8).map(|_| vector(0.2)).collect();
    let velocity: Vec<f64> = (0..4).flat_map(|_| vector(1.0)).collect();
    let (joints, contacts) = (random.usize(0..=6), random.usize(1..=8));
    let rows: Vec<ContactRows> = points[..contacts]
        .iter()
        .map(|offset| {
            let body = random.usize(0..=joints);
            let from = if body == 0 { [0.0; 3] } else { hinges[body - 1].0 };
            let point = [0, 1, 2].map(|k| from[k] + offset[k]);
            [[0., 0., 1.], [1., 0., 0.], [0., 1., 0.]].map(|direction| {
                let mut row = direction.to_vec();
                row.extend(cross(point, direction));
                for (j, (at, axis)) in hinges[..joints].iter().enumerate() {
                    let arm = [0, 1, 2].map(|k| point[k] - at[k]);
                    let turned: f64 = cross(arm, direction).iter().zip(axis).map(|(a, b)| a * b).sum();
                    row.push(if j < body { turned } else { 0.0 });
                }
                row
            })
        })
        .collect();
    let inverse: Vec<f64> =
        (0..6 + joints).map(|k| if k < 3 { 0.1 } else { 10f64.powf(spread * random.f64()) }).collect();
    assemble(tangents, &rows, &inverse, &velocity[..6 + joints], mu)
}

/// A random mechanism and its seed.
#[derive(Clone, Copy, Debug)]
pub struct Draw {
    pub seed: u64,
    pub tangents: usize,
    /// Decimal exponent of the spread of inertias.
    pub spread: f64,
    pub mu: f64,
}

impl Draw {
    /// A random problem: few or many coordinates, repeated or nearly repeated contacts or contacts of a foot, fast or slow.
    pub fn problem(self) -> Problem {
        let mut random = fastrand::Rng::with_seed(self.seed);
        let (contacts, dof) = (random.usize(1..=8), random.usize(3..=14));
        let inverse: Vec<f64> = (0..dof).map(|_| 10f64.powf(self.spread * random.f64())).collect();
        let vector = |random: &mut fastrand::Rng| (0..dof).map(|_| 2.0 * random.f64() - 1.0).collect::<Vec<f64>>();
        let rigid = dof >= 6 && random.bool();
        let mut rows: Vec<ContactRows> = Vec::new();
        for i in 0..contacts {
            if i > 0 && random.f64() < 0.2 {
                rows.push(rows[random.usize(0..i)].clone());
            } else if rigid {
                let mut row = on_body([random.f64() - 0.5, random.f64() - 0.5, -0.5]);
                row.iter_mut().for_each(|r| r.resize(dof, 0.0));
                rows.push(row);
            } else {
                rows.push([vector(&mut random), vector(&mut random), vector(&mut random)]);
            }
        }
        let size = 10f64.powf(4.0 * random.f64() - 4.0);
        let xdot: Vec<f64> = vector(&mut random).iter().map(|v| v * size).collect();
        let mut problem = assemble(self.tangents, &rows, &inverse, &xdot, self.mu);
        for approach in &mut problem.approach {
            *approach = if random.bool() { 0.0 } else { size * random.f64() };
        }
        problem
    }
}

/// Solves without memory.
pub fn solve(problem: &Problem, law: Law) -> (Solver, Report) {
    let mut solver = Solver::default();
    let report = solver.solve(problem, law, &mut Memory::default());
    (solver, report)
}

/// max(|f|, |b|) in energy units.
pub fn step_scale(problem: &Problem, solver: &Solver) -> f64 {
    let m = problem.rows();
    let root = |k: usize| problem.delassus[k * m + k].sqrt();
    (0..m)
        .filter(|&k| root(k) > 0.0)
        .map(|k| (solver.impulse[k] * root(k)).abs().max((problem.drift[k] / root(k)).abs()))
        .fold(0.0, f64::max)
}

pub fn assert_near(what: &str, value: f64, exact: f64, tolerance: f64) {
    assert!((value - exact).abs() <= tolerance * (1.0 + exact.abs()), "{what}: {value}, not {exact}");
}
