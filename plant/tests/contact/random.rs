//! Random problems, of any rank and scale.

use super::mechanism::{CORNERS, INVERSE, stirring_foot};
use super::{ContactRows, G, H, PIVOTED, assemble, on_body, solve};
use biped_plant::contact::{Memory, Problem, Solver};
use messages::scene::Law;

fn step_scale(problem: &Problem, solver: &Solver) -> f64 {
    let m = problem.rows();
    let root = |k: usize| problem.delassus[k * m + k].sqrt();
    (0..m).map(|k| (solver.impulse[k] * root(k)).abs().max((problem.drift[k] / root(k)).abs())).fold(0.0, f64::max)
}

/// A random mechanism: few or many coordinates, inertias up to 1 : 1e6, repeated or nearly repeated contacts, fast and slow, high and low
/// friction. Also returns the decimal exponent of the spread of inertias.
fn random_problem(random: &mut fastrand::Rng, law: Law) -> (Problem, u32) {
    let contacts = random.usize(1..=8);
    let dof = random.usize(3..=14);
    let spread = [0.0, 1.0, 3.0, 6.0][random.usize(0..4)];
    let inverse: Vec<f64> = (0..dof).map(|_| 10f64.powf(spread * random.f64())).collect();
    let vector = |random: &mut fastrand::Rng| (0..dof).map(|_| 2.0 * random.f64() - 1.0).collect::<Vec<f64>>();
    let rigid = dof >= 6 && random.bool();
    let mut rows: Vec<ContactRows> = Vec::new();
    for i in 0..contacts {
        if i > 0 && random.f64() < 0.2 {
            let again = rows[random.usize(0..i)].clone();
            rows.push(again);
        } else if rigid {
            // Contacts of a foot: coplanar points of one body, rank at most six.
            let mut row = on_body([random.f64() - 0.5, random.f64() - 0.5, -0.5]);
            row.iter_mut().for_each(|r| r.resize(dof, 0.0));
            rows.push(row);
        } else {
            rows.push([vector(random), vector(random), vector(random)]);
        }
    }
    let size = 10f64.powf(4.0 * random.f64() - 4.0);
    let xdot: Vec<f64> = vector(random).iter().map(|v| v * size).collect();
    let mu = [0.0, 0.2, 0.7, 1.5][random.usize(0..4)];
    let mut problem = assemble(law, &rows, &inverse, &xdot, mu);
    for approach in &mut problem.approach {
        *approach = if random.bool() { 0.0 } else { size * random.f64() };
    }
    (problem, spread as u32)
}

/// The multipliers of contact.rs: f_N (v_N - μ |v_F|) = 0 and v_N >= μ |v_F| instead of (18), (19).
#[test]
fn the_printed_program_has_the_multipliers_that_its_lagrangian_gives() {
    let mut random = fastrand::Rng::with_seed(1);
    let mut violated = 0;
    for _ in 0..2000 {
        let (problem, _) = random_problem(&mut random, Law::EnergyQp);
        let (solver, report) = solve(&problem, Law::EnergyQp);
        violated += usize::from(report.signorini > 1e-6);
        for i in 0..problem.contacts {
            let (k, mu) = (2 * i, problem.friction[i]);
            let root = |k: usize| problem.delassus[k * problem.rows() + k].sqrt();
            let (f, v) = (solver.impulse[k], solver.velocity[k] - mu * solver.velocity[k + 1].abs());
            let scale = step_scale(&problem, &solver);
            assert!(v / root(k) >= -1e-10 * scale, "v_N < mu |v_F| by {v}");
            assert!(f * v <= 1e-10 * scale * scale, "f_N (v_N - mu |v_F|) = {}", f * v);
        }
    }
    assert!(violated > 1000, "(19) held in all but {violated} of 2000 problems");
}

/// The energy minimum has one velocity. So has Coulomb's law with two tangents for a foot at ordinary friction. So a remembered basis must
/// not change it, while contacts open and close. With one tangent per contact, and nearly parallel tangents, contacts can jam each other:
/// (17)-(22) then have several solutions, and any of them may be found.
#[test]
fn a_warm_start_with_a_basis_gives_the_velocity_of_a_cold_start() {
    for law in PIVOTED {
        let (mut memory, mut solver) = (Memory::default(), Solver::default());
        let (mut warm, mut others) = (0, 0);
        for (touching, xdot) in stirring_foot(3000) {
            let contacts: Vec<ContactRows> = touching.iter().map(|&c| on_body(CORNERS[c])).collect();
            let mut problem = assemble(law, &contacts, &INVERSE, &xdot, 0.7);
            problem.id.clone_from(&touching);
            let (fresh, _) = solve(&problem, law);
            let report = solver.solve(&problem, law, &mut memory);
            assert!(report.own <= 1e-10 && !report.fallback, "{report:?}");
            warm += usize::from(report.warm);
            let difference =
                solver.velocity.iter().zip(&fresh.velocity).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            others += usize::from(difference > 1e-10 * G * H);
        }
        println!("{law:?}: {warm} of 3000 steps warm, {others} with another velocity");
        assert!(others == 0 || law == Law::Complementarity, "{law:?}: {others} of 3000 steps differ");
        assert!(warm > 2000, "{law:?}: {warm} of 3000 steps warm");
    }
}

/// Every random problem is solved, at any rank and scale, and the energy never rises.
#[test]
fn random_problems_are_solved() {
    let seed = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1995);
    println!("seed {seed}");
    let mut failed = 0;
    let mut random = fastrand::Rng::with_seed(seed);
    for law in PIVOTED {
        let (mut pivots, mut fallbacks, mut worst, mut gain) = (Vec::new(), [0; 2], 0.0_f64, f64::NEG_INFINITY);
        let mut unsolved = 0;
        let mut solver = Solver::default();
        for _ in 0..40_000 {
            let (problem, spread) = random_problem(&mut random, law);
            let report = solver.solve(&problem, law, &mut Memory::default());
            fallbacks[usize::from(spread > 3)] += usize::from(report.fallback);
            unsolved += usize::from(report.own.is_nan() || report.own > 1e-10);
            worst = worst.max(report.own);
            gain = gain.max(report.energy_gain / step_scale(&problem, &solver).powi(2));
            pivots.push(report.pivots);
        }
        pivots.sort_unstable();
        let at = |p: f64| pivots[(p * (pivots.len() - 1) as f64) as usize];
        println!(
            "{law:?}: residual {worst:.1e}, energy gain {gain:.1e}, fallbacks {fallbacks:?} (mass ratio to 1e3, 1e6), unsolved {unsolved}, pivots median {} p99.9 {} max {}",
            at(0.5),
            at(0.999),
            at(1.0),
        );
        assert!(gain <= 1e-12, "{law:?}: energy rose");
        failed += unsolved;
    }
    assert_eq!(failed, 0);
}

/// A solver has no state: what it solved before must not change results, or a run would not repeat after a reset.
#[test]
fn a_used_solver_gives_the_bits_of_a_new_one() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for law in PIVOTED {
        let mut used = Solver::default();
        for case in 0..500 {
            let problem = match case % 3 {
                // no motion, with dependent contacts: the next problem starts from a useless guess
                0 => {
                    let corners = [[0.1, 0.1], [0.1, -0.1], [-0.1, 0.1], [-0.1, -0.1]];
                    let rows = corners.map(|[x, y]| on_body([x, y, -0.5]));
                    assemble(law, &rows, &[1.0, 1.0, 1.0, 9.0, 9.0, 9.0], &[0.0, 0.0, -G * H, 0.0, 0.0, 0.0], 0.5)
                }
                _ => random_problem(&mut random, law).0,
            };
            let mut new = Solver::default();
            let reports = [&mut used, &mut new].map(|solver| solver.solve(&problem, law, &mut Memory::default()));
            assert_eq!(reports[0], reports[1], "{law:?}, case {case}");
            assert!(used.impulse.iter().zip(&new.impulse).all(|(a, b)| a.to_bits() == b.to_bits()), "{law:?} {case}");
        }
    }
}
