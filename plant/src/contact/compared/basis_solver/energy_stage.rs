//! The energy program (14)-(16) as an attempt: with printed normal rows, or with rows shifted until its optimum obeys Coulomb's law.

use super::super::super::tolerance::{PROXIMAL_ROUNDING, REFINEMENT_REDUCTION, SOLVED};
use super::super::energy_qp::minimises_energy;
use super::super::{square_cone, status};
use super::{BasisSolver, optimality};
use messages::scene::Law;

/// Restarts of the program at most; most problems need one.
const MAX_ROUNDS: usize = 14;
/// Proximal steps at most.
const MAX_REFINEMENTS: usize = 3;

impl BasisSolver {
    /// Solves the program from the edges of the present basis on; see [`super::super::energy_qp`].
    pub(super) fn energy_stage(&mut self, law: Law, pivots: &mut u32) -> bool {
        let d = self.scaled.facets();
        self.basis.iter_mut().for_each(|bits| *bits = status::edges(*bits, d));
        self.shift.reset(&self.scaled);
        self.energy_qp.reset(&self.scaled, &self.basis);
        for cones in 0..MAX_ROUNDS {
            let BasisSolver { scaled, shift, energy_qp, .. } = self;
            if !energy_qp.solve(scaled, &shift.value, pivots) {
                return false;
            }
            self.shift.min_norm = false;
            if !self.follow_shift_path(law, pivots) {
                continue;
            }
            self.shift.min_norm = cones % 2 == 0;
            if self.refine(law, pivots) {
                return true;
            }
        }
        // the start of the next attempt
        self.energy_qp.write(&self.scaled, &mut self.f, &mut self.basis);
        self.evaluate(law);
        false
    }

    /// For Coulomb's law, follows the path of the shift to the remaining slip. False if the program must restart with another shift.
    fn follow_shift_path(&mut self, law: Law, pivots: &mut u32) -> bool {
        let BasisSolver { scaled, shift, energy_qp, .. } = self;
        minimises_energy(law) || shift.follow_path(energy_qp, scaled, pivots)
    }

    /// Undoes the compliance down to rounding; true if the result is the solution.
    fn refine(&mut self, law: Law, pivots: &mut u32) -> bool {
        let (mut before, mut error) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..MAX_REFINEMENTS {
            if !self.energy_qp.solve(&self.scaled, &self.shift.value, pivots) {
                break;
            }
            if !self.follow_shift_path(law, pivots) {
                break;
            }
            self.energy_qp.write(&self.scaled, &mut self.f, &mut self.basis);
            error = self.evaluate(law);
            // an error that no longer shrinks lies along dependent directions
            if error <= PROXIMAL_ROUNDING || error > REFINEMENT_REDUCTION * before {
                break;
            }
            before = error;
        }
        error <= SOLVED
    }

    /// Computes velocity and residual of the present impulse, and marks the sliding contacts.
    fn evaluate(&mut self, law: Law) -> f64 {
        self.update_velocity();
        let BasisSolver { scaled, f, v, basis, .. } = self;
        status::mark_sliding(scaled, f, v, basis);
        let error = square_cone::natural_map(scaled, f, v, optimality(law));
        self.keep_best(error);
        error
    }
}
