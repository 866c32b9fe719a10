//! De Saxcé's shift of v_N, held during one energy minimum and updated between two, until it equals mu times the slip speed.
//!
//! Add μ s to v_N, and minimise ½f·A f + b·f over the cones. The minimum obeys Coulomb's law if s = |v_F|. Each minimum gives the next s.
//! If s overshoots to and fro, the updates become shorter. If s creeps on in one direction, each update is λ times the one before. Then s
//! goes to the sum of all that would follow, once, because other directions do not bear such a long update.
//!
//! # Source
//! Aitken (1926): the sum of a geometric sequence, from two of its terms.
//! Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction problem via convex optimization* (2011).

use super::super::projection::norm;
use super::super::round_cones::contact_rows;
use super::super::tolerance::{DAMPING, FIXED_POINT_PATIENCE, FIXED_POINT_PROGRESS, MAX_EXTRAPOLATION};

/// The held |v_F| of each contact; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct HeldShift {
    pub held: Vec<f64>,
    /// Difference between |v_F| of the last minimum and the held value.
    change: Vec<f64>,
    /// Part of that difference that an update adds [-].
    relaxation: f64,
    /// The least of the greatest differences so far, and the number of minima since.
    least: f64,
    stalled: u32,
}

impl HeldShift {
    /// Resets to zero shift of this many contacts.
    pub fn reset(&mut self, contacts: usize) {
        for list in [&mut self.held, &mut self.change] {
            list.clear();
            list.resize(contacts, 0.0);
        }
        (self.relaxation, self.least, self.stalled) = (1.0, f64::INFINITY, 0);
    }

    /// Updates the shift from the velocity at a minimum.
    pub fn update(&mut self, v: &[f64]) {
        let (mut greatest, mut along, mut square) = (0.0_f64, 0.0, 0.0);
        for (i, (held, last)) in self.held.iter().zip(&mut self.change).enumerate() {
            let v = contact_rows(v, i);
            let change = norm(v[1], v[2]) - held;
            greatest = greatest.max(change.abs());
            along += change * *last;
            square += *last * *last;
            *last = change;
        }
        let mut share = self.relaxation;
        self.stalled += 1;
        if greatest < FIXED_POINT_PROGRESS * self.least {
            (self.least, self.stalled) = (greatest, 0);
        } else if self.stalled > FIXED_POINT_PATIENCE {
            (self.least, self.stalled) = (greatest, 0);
            if along > 0.0 {
                share *= square / (square - along).max(square / MAX_EXTRAPOLATION); // 1/(1 - λ)
            } else {
                self.relaxation *= DAMPING;
                share = self.relaxation;
            }
        }
        self.held.iter_mut().zip(&self.change).for_each(|(held, change)| *held = (*held + share * change).max(0.0));
    }
}
