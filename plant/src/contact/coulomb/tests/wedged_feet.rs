//! Claim: where feet wedge, Newton's method spends few linear systems on attempts that fail.

use super::solve_recorded;

/// Six recorded steps of `stand` and `walk`, with the memories of the steps before. They take 151 linear systems. With four steps without progress
/// instead of three they take 203. With balanced weights also tried far from a solution they take 184, and with these never tried 215. If the
/// compliance of a balanced run begins at zero impulse, they take 324.
#[test]
fn feet_that_wedge_take_few_linear_systems() {
    let reports = solve_recorded(include_str!("../../../../tests/data/wedged_feet.json"));
    assert!(reports.iter().all(|report| !report.fallback), "{reports:?}");
    let systems: Vec<u32> = reports.iter().map(|report| report.pivots).collect();
    println!("linear systems: {systems:?}");
    assert!(systems.iter().sum::<u32>() <= 165, "{systems:?}");
}
