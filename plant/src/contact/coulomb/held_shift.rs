//! De Saxcé's shift of v_N, held during one energy minimum and updated between two, until it equals μ times the slip speed.
//!
//! Add μ s to v_N, and minimise ½f·A f + b·f over the cones. The minimum obeys Coulomb's law if s = |v_F|. Each minimum gives the next s.
//! The relaxation shrinks if s oscillates, and grows if s creeps in one direction.
//!
//! # Source
//! Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction problem via convex optimization* (2011).

use super::super::projection::norm;
use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{ACCELERATION, DAMPING, FIXED_POINT_PATIENCE, FIXED_POINT_PROGRESS, RESTART_DECADES};
use fastrand::Rng;

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
    is_monotone: bool,
}

impl HeldShift {
    /// Resets to zero shift of this many contacts.
    pub fn reset(&mut self, contacts: usize) {
        for list in [&mut self.held, &mut self.change] {
            list.clear();
            list.resize(contacts, 0.0);
        }
        (self.relaxation, self.least, self.stalled, self.is_monotone) = (1.0, f64::INFINITY, 0, false);
    }

    /// Resets to a random shift: for each contact a part of its slip without impulses, the logarithm of the part uniform.
    pub fn randomize(&mut self, cones: &RoundCones, random: &mut Rng) {
        self.reset(cones.contacts);
        for (i, held) in self.held.iter_mut().enumerate() {
            let [_, along, across] = contact_rows(&cones.drift, i);
            *held = norm(along, across) * libm::exp10(-RESTART_DECADES * random.f64());
        }
    }

    /// Updates the shift from the velocity at a minimum.
    pub fn update(&mut self, v: &[f64]) {
        let (mut greatest, mut along) = (0.0_f64, 0.0);
        for (i, (held, last)) in self.held.iter_mut().zip(&mut self.change).enumerate() {
            let v = contact_rows(v, i);
            let change = norm(v[1], v[2]) - *held;
            greatest = greatest.max(change.abs());
            along += change * *last;
            *last = change;
            *held = (*held + self.relaxation * change).max(0.0);
        }
        self.stalled += 1;
        if greatest < FIXED_POINT_PROGRESS * self.least {
            (self.least, self.stalled) = (greatest, 0);
        } else if self.stalled > FIXED_POINT_PATIENCE {
            (self.least, self.stalled) = (greatest, if self.is_monotone { FIXED_POINT_PATIENCE } else { 0 });
            self.relaxation *= if self.is_monotone { ACCELERATION } else { DAMPING };
        }
        self.is_monotone = along > 0.0;
    }
}
