//! Claim: where light bodies carry heavy ones, random weights find the impulse that no other stage finds.

use crate::contact::coulomb::{Law, Memory, Problem};
use crate::contact::solver::Solver;

/// Five recorded problems with masses of 1 : 1e9 and 1 : 1e14, with the memories of the steps before. Without random weights each of them is flagged,
/// with a natural map of 7e-9 to 1e-2.
#[test]
fn light_bodies_that_carry_heavy_ones_are_solved() {
    let text = include_str!("../../../../tests/data/heavy_on_light.json");
    let steps: Vec<(Problem, Memory)> = serde_json::from_str(text).expect("problems with memories");
    let reports =
        steps.into_iter().map(|(problem, mut memory)| Solver::default().solve(&problem, Law::Cone, &mut memory));
    let reports: Vec<_> = reports.collect();
    reports.iter().for_each(|report| println!("{:.1e}, {} linear systems", report.own, report.pivots));
    assert!(reports.iter().all(|report| !report.fallback), "{reports:?}");
}
