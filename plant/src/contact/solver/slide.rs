//! The energy program (14)-(16), with normal rows as printed or shifted until its optimum obeys Coulomb's law.

use super::super::energy_qp::minimises_energy;
use super::super::{residual, status};
use super::{FEW, SOLVED, Solver, yardstick};
use messages::scene::Law;

/// Most steps need one.
const ROUNDS: usize = 14;
/// Refinements at most.
const REFINEMENTS: usize = 3;
/// A residual of so much is rounding.
const ROUNDING: f64 = f64::EPSILON;

impl Solver {
    /// The program from the edges of the basis on; see [`crate::contact::energy_qp`].
    pub(super) fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        let d = self.scaled.facets();
        self.basis.iter_mut().for_each(|bits| *bits = status::edges(*bits, d));
        self.shift.begin(&self.scaled);
        self.energy_qp.begin(&self.scaled, &self.basis);
        let few = self.scaled.contacts <= FEW;
        for round in 0..ROUNDS {
            let Solver { scaled, shift, energy_qp, .. } = self;
            if !energy_qp.pivot(scaled, &shift.now, pivots) {
                return false;
            }
            self.shift.even = false;
            if few && !self.settle(law, pivots) {
                continue;
            }
            self.shift.even = round % 2 == 0;
            if self.refine(law, pivots) {
                return true;
            }
        }
        // a guess for the next way
        self.energy_qp.write(&self.scaled, &mut self.f, &mut self.basis);
        self.judge(law);
        false
    }

    /// Shifts the optimum to the slip that is left, where the law asks for that; false if another one has to be found.
    fn settle(&mut self, law: Law, pivots: &mut u32) -> bool {
        let Solver { scaled, shift, energy_qp, .. } = self;
        minimises_energy(law) || shift.settle(energy_qp, scaled, pivots)
    }

    /// Undoes what contacts have yielded by; whether that is the solution. Under one foot it is undone to rounding, and under more
    /// until that is solved: there most of what is left is along directions in which contacts hardly move.
    fn refine(&mut self, law: Law, pivots: &mut u32) -> bool {
        let few = self.scaled.contacts <= FEW;
        let enough = if few { ROUNDING } else { SOLVED };
        let (mut before, mut error) = (f64::INFINITY, f64::INFINITY);
        for pass in 0..REFINEMENTS {
            if !self.energy_qp.pivot(&self.scaled, &self.shift.now, pivots) {
                break;
            }
            if (few || pass == 0) && !self.settle(law, pivots) {
                break;
            }
            self.energy_qp.write(&self.scaled, &mut self.f, &mut self.basis);
            error = self.judge(law);
            // what no longer shrinks is along such directions
            if error <= enough || error > 0.1 * before {
                break;
            }
            before = error;
        }
        error <= SOLVED
    }

    /// Velocity and residual of the present impulse; notes what slides.
    fn judge(&mut self, law: Law) -> f64 {
        let Solver { scaled, f, v, basis, .. } = self;
        scaled.velocity(f, v);
        scaled.harden(f, v);
        status::slide(scaled, f, v, basis);
        let error = residual::natural_map(scaled, f, v, yardstick(law));
        self.note(error);
        error
    }
}
