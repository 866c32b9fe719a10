//! Time of one contact solve: `cargo run --release -p plant --example time_contact`.
//!
//! A random mechanism of 14 coordinates stands on one or two rigid feet (A of rank 6 or 12) or on single points. "Warm"
//! solves the same contacts for slowly changing velocities, "cold" forgets the basis before each step.

#![expect(clippy::unwrap_used, reason = "an example")]

use messages::scene::Law;
use plant::contact::{Memory, Problem, Solver, tangents};
use std::time::Instant;

const DOF: usize = 14;
const STEPS: usize = 4000;

/// Twist of each foot as a linear map of the coordinates, six rows a foot, in units that make H the identity.
struct Robot {
    feet: Vec<[[f64; DOF]; 6]>,
}

impl Robot {
    fn random(random: &mut fastrand::Rng) -> Self {
        let mut row = |inertia: f64| std::array::from_fn(|_| (2.0 * random.f64() - 1.0) / inertia.sqrt());
        let mut foot = || [14.0, 14.0, 14.0, 0.8, 0.7, 0.2].map(&mut row);
        Robot { feet: vec![foot(), foot()] }
    }

    /// The problem of `contacts` corners, four a foot, when the feet would freely move with these twists.
    fn problem(&self, law: Law, contacts: usize, twist: &[[f64; 6]; 2]) -> Problem {
        let mut problem = Problem::default();
        problem.reset(contacts, tangents(law));
        problem.friction.fill(0.7);
        let mut rows: Vec<[f64; DOF]> = Vec::new();
        for i in 0..contacts {
            let foot = i / 4;
            let [x, y, z] = [[0.1, -0.06][i % 2], [0.04, -0.04][i / 2 % 2], -0.05];
            let directions = [[0., 0., 1., y, -x, 0.], [1., 0., 0., 0., z, -y], [0., 1., 0., -z, 0., x]];
            let speed = directions.map(|d| (0..6).map(|k| d[k] * twist[foot][k]).sum::<f64>());
            let slip = speed[1].hypot(speed[2]);
            let (c, s) = (speed[1] / slip, speed[2] / slip);
            let along: [f64; 6] = std::array::from_fn(|k| c * directions[1][k] + s * directions[2][k]);
            let across: [f64; 6] = std::array::from_fn(|k| c * directions[2][k] - s * directions[1][k]);
            for (k, d) in [directions[0], along, across][..=problem.tangents].iter().enumerate() {
                rows.push(std::array::from_fn(|j| (0..6).map(|k| d[k] * self.feet[foot][k][j]).sum()));
                problem.drift[i * (1 + problem.tangents) + k] = [speed[0], slip, 0.0][k];
            }
        }
        let m = problem.rows();
        for i in 0..m {
            for j in 0..m {
                problem.delassus[i * m + j] = (0..DOF).map(|k| rows[i][k] * rows[j][k]).sum();
            }
        }
        problem
    }
}

/// Median and 99th percentile [us], and shares of warm and fallback, over slowly varying steps.
fn time(robot: &Robot, law: Law, contacts: usize, slide: f64, cold: bool) -> [f64; 6] {
    let mut random = fastrand::Rng::with_seed(1);
    let (mut solver, mut memory) = (Solver::default(), Memory::default());
    let mut times = Vec::with_capacity(STEPS);
    let (mut warm, mut fallback, mut pivots, mut worst) = (0, 0, 0, 0.0_f64);
    let phases: [[f64; 6]; 2] = std::array::from_fn(|_| std::array::from_fn(|_| random.f64() * std::f64::consts::TAU));
    for step in 0..STEPS {
        let t = step as f64 * 5e-4;
        // One step of gravity, and drives that push the feet about.
        let twist = std::array::from_fn(|foot| {
            std::array::from_fn(|k| {
                let wave = (std::f64::consts::TAU * (1.0 + k as f64 / 3.0) * t + phases[foot][k]).sin();
                [slide + 1e-3 * wave, 1e-3 * wave, -5e-3 + 1e-3 * wave, 0.02 * wave, 0.02 * wave, 0.01 * wave][k]
            })
        });
        let problem = robot.problem(law, contacts, &twist);
        if cold {
            memory = Memory::default();
        }
        let start = Instant::now();
        let report = solver.solve(&problem, law, &mut memory);
        times.push(start.elapsed().as_nanos() as f64 / 1e3);
        warm += usize::from(report.warm);
        fallback += usize::from(report.fallback);
        pivots += report.pivots;
        worst = worst.max(report.own);
    }
    times.sort_by(|a, b| a.partial_cmp(b).unwrap());
    let share = |n: usize| n as f64 / STEPS as f64;
    [times[STEPS / 2], times[STEPS * 99 / 100], share(warm), share(fallback), f64::from(pivots) / STEPS as f64, worst]
}

fn main() {
    let robot = Robot::random(&mut fastrand::Rng::with_seed(1995));
    println!("law             contacts  motion  memory   median us  p99 us  warm   fallback  pivots  residual");
    for law in [Law::EnergyQp, Law::Complementarity, Law::Aligned] {
        for contacts in [1, 4, 8] {
            for (motion, slide) in [("stand", 0.0), ("slide", 0.5)] {
                for (memory, cold) in [("cold", true), ("warm", false)] {
                    let [median, p99, warm, fallback, pivots, worst] = time(&robot, law, contacts, slide, cold);
                    println!(
                        "{:14}  {contacts:8}  {motion:6}  {memory:6}  {median:10.2}  {p99:6.2}  {warm:.3}  {fallback:8.4}  {pivots:6.1}  {worst:.1e}",
                        format!("{law:?}")
                    );
                }
            }
        }
    }
}
