//! The energy minimum over cones by an external interior-point solver (clarabel): the reference of the convex laws.
//!
//! It minimises f·A f/2 + f·(b + shift). A second-order cone holds (μ f_N, f_F) of each contact, or (bound, f_F) together with f_N >= 0.
//! The solver ends at about 1e-9, and Newton's method finds the last digits. It is the only solver here that always allocates.

use super::super::round_cones::RoundCones;
use super::super::tolerance::{CLARABEL_TOLERANCE, COMPLIANCE};
use super::condition::Condition;
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SupportedConeT};
use std::cmp::Ordering;

/// Iterations of the external solver at most. The limit only ends a program without a minimum.
const MAX_ITERATIONS: u32 = 100;

/// The solver. It has no state.
#[derive(Clone, Debug, Default)]
pub(super) struct ConeQp;

impl ConeQp {
    /// Writes the minimum of a convex condition and returns the number of iterations. Leaves `f` unchanged if there is no minimum.
    pub fn solve(&mut self, cones: &RoundCones, condition: Condition<'_>, f: &mut [f64]) -> u32 {
        let n = f.len();
        if n == 0 || !cones.size.is_finite() || cones.size == 0.0 || cones.delassus.iter().any(|a| !a.is_finite()) {
            return 0;
        }
        // The compliance bounds the internal impulses of jammed contacts.
        let upper = |k: usize, l: usize| match k.cmp(&l) {
            Ordering::Less => cones.delassus[k * n + l],
            Ordering::Equal => cones.delassus[k * n + l] + COMPLIANCE,
            Ordering::Greater => 0.0,
        };
        let energy: Vec<Vec<f64>> = (0..n).map(|k| (0..n).map(|l| upper(k, l)).collect()).collect();
        let mut linear: Vec<f64> = cones.drift.iter().map(|b| b / cones.size).collect();
        // The constraints have the form of the external solver: `right − rows f` lies in the cones.
        let (mut rows, mut right, mut constraints) = (Vec::new(), Vec::new(), Vec::new());
        let mut constrain = |entries: &[(usize, f64)], constant: f64| {
            let mut row = vec![0.0; n];
            entries.iter().for_each(|&(k, x)| row[k] = x);
            rows.push(row);
            right.push(constant);
        };
        for i in 0..cones.contacts {
            let k = 3 * i;
            match condition {
                Condition::Bound(bound) => {
                    constrain(&[(k, -1.0)], 0.0);
                    constraints.push(SupportedConeT::NonnegativeConeT(1));
                    constrain(&[], bound[i] / cones.size);
                }
                Condition::Energy(shift) => {
                    linear[k] += shift.get(i).copied().unwrap_or(0.0) / cones.size;
                    constrain(&[(k, -cones.friction[i])], 0.0);
                }
                Condition::Coulomb | Condition::Polygon(_) => return 0,
            }
            constrain(&[(k + 1, -1.0)], 0.0);
            constrain(&[(k + 2, -1.0)], 0.0);
            constraints.push(SupportedConeT::SecondOrderConeT(3));
            if cones.friction[i] == 0.0 {
                constrain(&[(k, -1.0)], 0.0);
                constraints.push(SupportedConeT::NonnegativeConeT(1));
            }
        }
        let settings = DefaultSettings {
            verbose: false,
            tol_gap_abs: CLARABEL_TOLERANCE,
            tol_gap_rel: CLARABEL_TOLERANCE,
            tol_feas: CLARABEL_TOLERANCE,
            max_iter: MAX_ITERATIONS,
            ..DefaultSettings::default()
        };
        let (energy, rows) = (CscMatrix::from(&energy), CscMatrix::from(&rows));
        let Ok(mut solver) = DefaultSolver::new(&energy, &linear, &rows, &right, &constraints, settings) else {
            return 0;
        };
        solver.solve();
        if solver.solution.x.iter().all(|x| x.is_finite()) {
            f.iter_mut().zip(&solver.solution.x).for_each(|(f, x)| *f = x * cones.size);
        }
        solver.info.iterations
    }
}
