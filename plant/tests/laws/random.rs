//! Claims over random mechanisms.

use super::support::*;
use biped_plant::contact::{Memory, Problem, Solver, is_plastic, tangents};
use messages::scene::{Iteration, Law};
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};
use std::cell::Cell;

/// An impulse well inside every cone that stops the free motion is the solution of every law: nothing moves.
///
/// The energy minimum has one velocity, so it must be this one. Coulomb's law has several solutions where limbs jam. A solution with
/// motion must then obey the law as well, and must be rare. Fixed points that do not converge are flagged, and must be rare too.
#[test]
fn all_laws_agree_when_everything_sticks() {
    let (cases, others) = (400, Cell::new(0));
    let config =
        ProptestConfig { cases, rng_seed: RngSeed::Fixed(7), failure_persistence: None, ..ProptestConfig::default() };
    let mechanisms = (any::<u64>(), 0.0..2.0, 0.05..1.0);
    let outcome = TestRunner::new(config).run(&mechanisms, |(seed, spread, mu)| {
        for law in Law::ALL.into_iter().filter(|law| !matches!(law, Law::SpringDamper | Law::Sweep(_))) {
            let mut problem = chain(seed, tangents(law), spread, mu);
            stop(&mut problem, seed, mu);
            let (mut solver, mut memory) = (Solver::default(), Memory::default());
            let mut report = solver.solve(&problem, law, &mut memory);
            if law == Law::Lagged {
                // The bounds come from the steps before.
                (0..50).for_each(|_| report = solver.solve(&problem, law, &mut memory));
            }
            let (m, scale) = (problem.rows(), step_scale(&problem, &solver));
            let speeds = solver.velocity.iter().enumerate().map(|(k, v)| v.abs() / problem.delassus[k * m + k].sqrt());
            let moved = speeds.fold(0.0, f64::max);
            if moved > 1e-9 * scale {
                let minimum = matches!(law, Law::EnergyQp | Law::EnergyQpGap | Law::ConeQp);
                // a fixed point that does not converge sets `fallback`
                let told = report.fallback && matches!(law, Law::FixedPoint(_));
                let obeys = told || report.own <= 1e-10;
                prop_assert!(!minimum && obeys, "{law} moves at {moved:e} of {scale:e}: {report:?}");
                others.set(others.get() + 1);
            }
        }
        Ok(())
    });
    println!("{} of {} answers move", others.get(), 12 * cases);
    outcome.expect("every law stops the chain");
    assert!(others.get() <= 12 * cases / 100);
}

/// With redundant contacts, fixed points converge although the minima creep along directions that hardly change the energy.
///
/// With under-relaxation only, six of a thousand such problems were given up; the first problem here is one of them.
#[test]
fn creeping_fixed_points_converge() {
    let (count, seed) = (5000, fastrand::u64(..));
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let known = (5975009352001708559, 1.4625881658911097, 0.5828909357745);
    let drawn = (1..count).map(|_| (random.u64(..), 2.0 * random.f64(), 0.05 + 0.95 * random.f64()));
    let mut unsolved = 0;
    for (k, (seed, spread, mu)) in std::iter::once(known).chain(drawn).enumerate() {
        for iteration in [Iteration::Tresca, Iteration::Aclm] {
            let mut problem = chain(seed, 2, spread, mu);
            stop(&mut problem, seed, mu);
            let (_, report) = solve(&problem, Law::FixedPoint(iteration));
            let solved = report.own <= 1e-10;
            assert_ne!(solved, report.fallback, "{iteration:?}: a failure must be flagged: {report:?}");
            assert!(solved || k > 0, "{iteration:?}: {report:?}");
            unsolved += u32::from(!solved);
        }
    }
    println!("{unsolved} of {count} problems given up");
    assert!(unsolved <= count / 1000);
}

/// Sets the free motion to one that an impulse in the middle of the cones stops.
fn stop(problem: &mut Problem, seed: u64, mu: f64) {
    let (m, stride) = (problem.rows(), 1 + problem.tangents);
    let mut random = fastrand::Rng::with_seed(seed);
    let mut inside = vec![0.0; m];
    for f in inside.chunks_exact_mut(stride) {
        let normal = 0.1 + random.f64();
        f[0] = normal;
        // Draws both parts with one tangent as well.
        let shares = [random.f64() - 0.5, random.f64() - 0.5];
        f[1..].iter_mut().zip(shares).for_each(|(f_t, share)| *f_t = 0.4 * share * mu * normal);
    }
    for (b, row) in problem.drift.iter_mut().zip(problem.delassus.chunks_exact(m)) {
        *b = -row.iter().zip(&inside).map(|(a, f)| a * f).sum::<f64>();
    }
}

/// Every law over 1e5 random problems in total: solved to its own conditions, and the energy never rises.
#[test]
fn random_problems_are_solved_and_plastic_laws_never_raise_the_energy() {
    let count: u64 = std::env::var("COUNT").ok().and_then(|s| s.parse().ok()).unwrap_or(8_400);
    let seed: u64 = std::env::var("SEED").ok().and_then(|s| s.parse().ok()).unwrap_or(1995);
    println!("seed {seed}");
    for law in Law::ALL.into_iter().filter(|law| is_plastic(*law)) {
        let (mut pivots, mut unsolved, mut gain) = (Vec::new(), [0; 2], f64::NEG_INFINITY);
        let mut solver = Solver::default();
        for k in 0..count {
            let spread = [0.0, 1.0, 3.0, 6.0][k as usize % 4];
            let mu = [0.0, 0.2, 0.7, 1.5][k as usize / 4 % 4];
            let problem = Draw { seed: seed.wrapping_add(k << 20), tangents: tangents(law), spread, mu }.problem();
            let report = solver.solve(&problem, law, &mut Memory::default());
            assert!(report.own <= 1e-10 || report.fallback, "{law}: a failure must be flagged: {report:?}");
            unsolved[usize::from(spread > 3.0)] += u64::from(report.own > 1e-10);
            gain = gain.max(report.energy_gain / step_scale(&problem, &solver).powi(2));
            pivots.push(report.pivots);
        }
        pivots.sort_unstable();
        let at = |p: f64| pivots[(p * (pivots.len() - 1) as f64) as usize];
        println!(
            "{law}: unsolved {unsolved:?} of {count} (mass ratio to 1e3, 1e6), energy gain {gain:.1e}, pivots median {} p99 {} max {}",
            at(0.5),
            at(0.99),
            at(1.0)
        );
        assert!(gain <= 1e-12, "{law}: energy rose by {gain:e}");
        // An iteration without a proof of convergence may give up, with `fallback` set.
        let allowed = match law {
            Law::FixedPoint(_) => [count / 50, count / 50],
            Law::Facets(_) => [count / 5000, count / 500],
            Law::Cone => [count / 2000, count / 500], // judged contact by contact, each with its own scale
            _ => [0, count / 1000],
        };
        assert!(unsolved[0] <= allowed[0] && unsolved[1] <= allowed[1], "{law}: {unsolved:?}");
    }
}

/// Both iterations end at the solution of the round cone; facets approach it as their number grows.
#[test]
fn more_facets_and_more_minima_lead_to_the_cone() {
    let laws = [
        Law::Facets(4),
        Law::Facets(8),
        Law::Facets(16),
        Law::FixedPoint(Iteration::Tresca),
        Law::FixedPoint(Iteration::Aclm),
    ];
    let (mut all, mut several) = (Vec::new(), 0);
    for seed in 0..1000 {
        let problem = Draw { seed, tangents: 2, spread: 1.0, mu: 0.2 }.problem();
        let (exact, report) = solve(&problem, Law::Cone);
        assert!(report.own <= 1e-10, "{report:?}");
        let scale = problem.drift.iter().fold(0.0, |scale: f64, b| scale.max(b.abs()));
        let away = laws.map(|law| {
            let (solver, report) = solve(&problem, law);
            if report.fallback {
                return f64::NAN;
            }
            solver.velocity.iter().zip(&exact.velocity).fold(0.0, |away: f64, (a, b)| away.max((a - b).abs())) / scale
        });
        if away.iter().all(|away| away.is_finite()) {
            all.push(away);
            several += usize::from(away[3].max(away[4]) > 1e-7);
        }
    }
    let cases = all.len();
    let median = [0, 1, 2, 3, 4].map(|law| {
        all.sort_by(|a, b| a[law].total_cmp(&b[law]));
        all[cases * 3 / 4][law]
    });
    println!("third quartile of the distance from the cone's velocity, {cases} of 1000 problems: {laws:?} {median:?}");
    println!("{several} problems have another answer, as good to 1e-10");
    assert!(cases >= 990 && several <= 10);
    assert!(median[1] < 0.6 * median[0] && median[2] < 0.6 * median[1], "half each: {median:?}");
}
