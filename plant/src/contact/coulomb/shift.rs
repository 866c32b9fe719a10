//! De Saxcé's shift of v_N, held from one energy minimum to the next until it is that of the slip.
//!
//! The minimum of ½f·A f + b·f over the cones with μ s added to v_N obeys Coulomb's law where s = |v_F|. Each minimum gives the next s.
//! Where that overshoots to and fro, less of it is taken; where it creeps on the same way, more.
//!
//! # Source
//! Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction problem via convex optimization* (2011).

use super::super::project::length;
use super::super::round::part;

/// Minima without progress before more or less of a change is taken.
const PATIENCE: u32 = 2;
/// Progress is a change that is less than this part of the least before [-].
const PROGRESS: f64 = 0.9;

/// |v_F| of each contact, as held; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Shift {
    pub held: Vec<f64>,
    /// How the last minimum would have changed it.
    rise: Vec<f64>,
    /// Part of a change that is taken [-].
    share: f64,
    /// The least change so far, and minima since.
    least: f64,
    waited: u32,
    creeps: bool,
}

impl Shift {
    /// None, of so many contacts.
    pub fn begin(&mut self, contacts: usize) {
        for list in [&mut self.held, &mut self.rise] {
            list.clear();
            list.resize(contacts, 0.0);
        }
        (self.share, self.least, self.waited, self.creeps) = (1.0, f64::INFINITY, 0, false);
    }

    /// Takes over from the velocity at a minimum.
    pub fn follow(&mut self, v: &[f64]) {
        let (mut change, mut along) = (0.0_f64, 0.0);
        for (i, (held, last)) in self.held.iter_mut().zip(&mut self.rise).enumerate() {
            let v = part(v, i);
            let rise = length(v[1], v[2]) - *held;
            change = change.max(rise.abs());
            along += rise * *last;
            *last = rise;
            *held = (*held + self.share * rise).max(0.0);
        }
        self.waited += 1;
        if change < PROGRESS * self.least {
            (self.least, self.waited) = (change, 0);
        } else if self.waited > PATIENCE {
            (self.least, self.waited) = (change, if self.creeps { PATIENCE } else { 0 });
            self.share *= if self.creeps { 2.0 } else { 0.5 };
        }
        self.creeps = along > 0.0;
    }
}
