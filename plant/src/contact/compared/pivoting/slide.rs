//! The energy program (14)-(16), with normal rows as printed or shifted until its optimum obeys Coulomb's law.

use super::super::super::tolerance::SOLVED;
use super::super::energy_qp::minimises_energy;
use super::super::{diamond, status};
use super::{Pivoting, yardstick};
use messages::scene::Law;

/// Most steps need one.
const ROUNDS: usize = 14;
/// Refinements at most.
const REFINEMENTS: usize = 3;
/// A residual of so much is rounding.
const ROUNDING: f64 = f64::EPSILON;

impl Pivoting {
    /// The program from the edges of the basis on; see [`super::super::energy_qp`].
    pub(super) fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        let d = self.scaled.facets();
        self.basis.iter_mut().for_each(|bits| *bits = status::edges(*bits, d));
        self.shift.begin(&self.scaled);
        self.energy_qp.begin(&self.scaled, &self.basis);
        for round in 0..ROUNDS {
            let Pivoting { scaled, shift, energy_qp, .. } = self;
            if !energy_qp.pivot(scaled, &shift.now, pivots) {
                return false;
            }
            self.shift.even = false;
            if !self.settle(law, pivots) {
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
        let Pivoting { scaled, shift, energy_qp, .. } = self;
        minimises_energy(law) || shift.settle(energy_qp, scaled, pivots)
    }

    /// Undoes what contacts have yielded by, to rounding; whether that is the solution.
    fn refine(&mut self, law: Law, pivots: &mut u32) -> bool {
        let (mut before, mut error) = (f64::INFINITY, f64::INFINITY);
        for _ in 0..REFINEMENTS {
            if !self.energy_qp.pivot(&self.scaled, &self.shift.now, pivots) {
                break;
            }
            if !self.settle(law, pivots) {
                break;
            }
            self.energy_qp.write(&self.scaled, &mut self.f, &mut self.basis);
            error = self.judge(law);
            // what no longer shrinks is along such directions
            if error <= ROUNDING || error > 0.1 * before {
                break;
            }
            before = error;
        }
        error <= SOLVED
    }

    /// Velocity and residual of the present impulse; notes what slides.
    fn judge(&mut self, law: Law) -> f64 {
        self.find_velocity();
        let Pivoting { scaled, f, v, basis, .. } = self;
        status::slide(scaled, f, v, basis);
        let error = diamond::natural_map(scaled, f, v, yardstick(law));
        self.note(error);
        error
    }
}
