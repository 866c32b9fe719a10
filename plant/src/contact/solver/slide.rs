//! Coulomb's law by the energy program (14)-(16), whose normal rows are shifted until they are what they should be.

use super::super::{active_set, residual};
use super::{FEW, SOLVED, Solver, yardstick};
use messages::scene::Law;

/// Most steps need one or two.
const ROUNDS: usize = 24;
/// Rounds in which the block may say what the next shift is, if its residual is no more than so many times the optimum's.
const TRUSTING: usize = 4;
const TRUSTED: f64 = 1e4;

impl Solver {
    /// The energy program (14)-(16), with mu |v_F| of its last solution added to each v_N.
    ///
    /// Its optimum has v_N >= mu |v_F|: that is Coulomb's law where nothing slides, and the shift makes it so where
    /// something does (De Saxcé; Acary & Cadoux). Long before the shift has settled the optimum says what slides where,
    /// and the block has the solution. If it has not, something else slides; but at first, while it is not far off ([`TRUSTED`]), the
    /// slip of the block, which is that of the settled shift if just this slides, makes the best next shift. (The pressure under one
    /// foot that turns as it slides is not unique, and the shift by itself ends nearer to an even one.)
    ///
    /// The first round begins with the rays along which contacts pushed in the step before; where one stuck, with those of its
    /// impulse in the block that failed. Each round also undoes what contacts yielded by in the one before (a proximal step), so
    /// that the limit is the solution of rigid ones. What is solved without the block may be solved better by it; a block that
    /// failed is not asked twice.
    pub(super) fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        let (d, stride) = (self.scaled.facets(), self.scaled.stride());
        for (i, (bits, f)) in self.basis.iter_mut().zip(self.f.chunks_exact(stride)).enumerate() {
            let pushed = active_set::rays(*bits, d);
            let sticks = pushed == (1 << d) - 1;
            *bits = if sticks { active_set::rays_of(&self.scaled, i, f) } else { pushed };
        }
        self.shifted.clone_from(&self.scaled.drift);
        self.shift.begin(self.scaled.contacts);
        self.tried.clear();
        for round in 0..ROUNDS {
            let Solver { scaled, shift, shifted, energy_qp, f, v, basis, .. } = self;
            if !energy_qp.pivot(scaled, shifted, basis, f, round > 0, pivots) {
                return false;
            }
            scaled.velocity(f, v);
            scaled.harden(f, v);
            let error = residual::natural_map(scaled, f, v, yardstick(law));
            basis.iter_mut().for_each(|bits| *bits |= active_set::RAYS);
            if error <= SOLVED {
                self.note(error);
                let of_block = self.try_basis(law);
                if of_block.is_nan() || of_block >= self.least {
                    self.take_best();
                }
                return true;
            }
            scaled.lead(f, shifted);
            shift.advance(|i| residual::slip(scaled, i, v));
            active_set::slide(scaled, f, v, basis);
            self.note(error);
            if self.basis != self.tried {
                self.tried.clone_from(&self.basis);
                let of_block = self.try_basis(law);
                if of_block <= SOLVED {
                    return true;
                }
                let Solver { scaled, shift, v, .. } = self;
                if scaled.contacts > FEW && round < TRUSTING && of_block < TRUSTED * error {
                    shift.jump(|i| residual::slip(scaled, i, v));
                }
            }
            let Solver { shift, shifted, .. } = self;
            let normals = shifted.iter_mut().step_by(stride);
            normals.zip(&shift.now).for_each(|(v, shift)| *v += shift);
        }
        false
    }
}

/// What is added to each v_N: a fixed point of what the slip that it leaves asks for.
///
/// While the same contacts slide that map is affine, with one slow direction, which two rounds tell.
///
/// # Source
/// Anderson, *Iterative procedures for nonlinear integral equations* (1965), with a memory of one round.
#[derive(Clone, Debug, Default)]
pub(super) struct Shift {
    now: Vec<f64>,
    /// What the round before asked for, and by how much that was more than there was.
    asked: Vec<f64>,
    change: Vec<f64>,
}

impl Shift {
    /// None, of so many contacts.
    fn begin(&mut self, contacts: usize) {
        for list in [&mut self.now, &mut self.asked, &mut self.change] {
            list.clear();
            list.resize(contacts, 0.0);
        }
    }

    /// The next is what this slip asks for, as it is.
    fn jump(&mut self, slip: impl Fn(usize) -> f64) {
        self.now.iter_mut().enumerate().for_each(|(i, now)| *now = slip(i));
    }

    /// The next, given what the last one asks for at each contact.
    fn advance(&mut self, slip: impl Fn(usize) -> f64) {
        let (mut along, mut square) = (0.0, 0.0);
        for i in 0..self.now.len() {
            let change = slip(i) - self.now[i];
            along += change * (change - self.change[i]);
            square += (change - self.change[i]).powi(2);
        }
        let back = if square > 0.0 { along / square } else { 0.0 };
        for i in 0..self.now.len() {
            let (asked, before) = (slip(i), self.asked[i]);
            (self.asked[i], self.change[i]) = (asked, asked - self.now[i]);
            self.now[i] = f64::max(asked - back * (asked - before), 0.0);
        }
    }
}
