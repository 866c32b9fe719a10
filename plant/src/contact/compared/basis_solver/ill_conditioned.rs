//! Claim: problems of two feet that almost lock each other need 32 digits, and Lemke's method with 32 digits solves them.

use super::*;

/// Problems of two feet that turn against directions with an inverse mass of 1e-12, and of a tumbling box.
fn problems() -> Vec<Problem> {
    serde_json::from_str(include_str!("../../../../tests/data/all_but_singular.json")).expect("problems")
}

#[test]
fn almost_locked_feet_are_solved_to_rounding_in_few_pivots() {
    for problem in problems() {
        let report = BasisSolver::default().solve(&problem, Law::Aligned, &mut Memory::default(), &mut Vec::new());
        println!("{} contacts: {report:?}", problem.contacts);
        assert!(report.own <= 1e-11 && !report.fallback, "{report:?}");
        assert!(report.pivots as usize <= 10 * problem.rows(), "{report:?}");
    }
}

#[test]
fn sixteen_digits_do_not_solve_all_of_them() {
    let problems = problems();
    let missed = problems.iter().filter(|problem| {
        let mut solver = BasisSolver::default();
        solver.scaled.set(problem, Law::Aligned);
        solver.best.resize(problem.rows(), 0.0);
        solver.basis.resize(problem.contacts, 0);
        !solver.with_compliance(COMPLIANCE, |solver| solver.energy_stage(Law::Aligned, &mut 0))
    });
    assert!(missed.count() > 0, "the control detects nothing: choose harder problems");
}
