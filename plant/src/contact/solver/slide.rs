//! Coulomb's law by the energy program (14)-(16), whose normal rows are shifted until they are what they should be.

use super::super::{active_set, residual};
use super::{SOLVED, Solver, yardstick};
use messages::scene::Law;

/// Most steps need one. Where a foot turns against what hardly yields, each asks for the same small change as the one
/// before: thousands would not do.
const ROUNDS: usize = 4;

impl Solver {
    /// The energy program (14)-(16), with mu |v_F| of its last solution added to each v_N.
    ///
    /// Its optimum has v_N >= mu |v_F|: that is Coulomb's law where nothing slides, and the shift makes it so where
    /// something does (De Saxcé; Acary & Cadoux). Long before the shift has settled the optimum says what slides where,
    /// and the block has the solution.
    ///
    /// Each round also undoes what contacts yielded by in the one before (a proximal step), so that the limit is the
    /// solution of rigid ones.
    pub(super) fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        for bits in &mut self.basis {
            *bits = active_set::rays(*bits, self.scaled.facets());
        }
        self.rays.clone_from(&self.basis);
        let stride = self.scaled.stride();
        self.proximal.copy(&self.scaled);
        self.shift.clear();
        self.shift.resize(self.scaled.contacts, 0.0);
        for round in 0..ROUNDS {
            let Solver { scaled, shift, proximal, energy_qp, block, f, v, basis, rays, .. } = self;
            basis.clone_from(rays);
            if !energy_qp.pivot(proximal, block, basis, f, v, round > 0, pivots) {
                return false;
            }
            rays.clone_from(basis);
            for (v, (shifted, b)) in v.iter_mut().zip(proximal.drift.iter().zip(&scaled.drift)) {
                *v -= shifted - b;
            }
            scaled.harden(f, v);
            let error = residual::natural_map(scaled, f, v, yardstick(law));
            basis.iter_mut().for_each(|bits| *bits |= active_set::RAYS);
            if error <= SOLVED {
                return true;
            }
            scaled.lead(f, &mut proximal.drift);
            for (i, (v, shift)) in v.chunks_exact(stride).zip(shift).enumerate() {
                *shift += residual::slip(scaled, i, v) - *shift;
                proximal.drift[i * stride] += *shift;
            }
            active_set::slide(scaled, f, v, basis);
            self.note(error);
            if self.is_solved(law) || (round == 0 || round + 1 == ROUNDS) && self.settle(law, pivots) {
                return true;
            }
        }
        false
    }
}
