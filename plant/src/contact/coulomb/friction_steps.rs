//! Friction in steps: solves the problem with less friction first, and starts each problem from the solution of the one before.
//!
//! ```text
//!   for μ_max = 1, 10, 100, …   f: solution with friction min(μ, μ_max), from the modes and the impulse of the one before
//!   f: solution with friction μ, from there
//! ```
//!
//! At great friction a contact with hardly any pressure may hold or drag a link, and its cone is almost a half-space. Neither Newton's method
//! nor interior points find then which contacts do so. Most contacts that stick at μ = 1 or 10 also stick at greater friction.
//!
//! # Source
//! Continuation in a parameter: Allgower & Georg, *Numerical Continuation Methods* (1990).

use super::super::round_cones::contact_rows;
use super::super::tolerance::{FIRST_FRICTION, FRICTION_FACTOR};
use super::Coulomb;
use super::iterate::{Limits, Weight};

impl Coulomb {
    /// Solves with friction that grows up to that of the problem. If a problem on the way is unsolved, Newton's method starts from the one before.
    /// False if it fails, or if friction is small.
    pub(super) fn friction_steps(&mut self) -> bool {
        let greatest = self.cones.friction.iter().fold(0.0, |most: f64, mu| most.max(*mu));
        if greatest <= FIRST_FRICTION {
            return false;
        }
        let Coulomb { cones, selected, part, guess, initial, iterate, .. } = self;
        selected.clear();
        selected.extend(0..cones.contacts);
        let part = part.get_or_insert_default();
        part.begin_selection(cones, selected);
        let mut limit = FIRST_FRICTION;
        while limit < greatest {
            let limited = part.cones.friction.iter_mut().zip(&cones.friction);
            limited.for_each(|(limited, mu)| *limited = mu.min(limit));
            part.best.error = f64::INFINITY;
            if !(part.newton_from_memory(Limits::NORMAL) || part.interior_points()) {
                break;
            }
            part.start_from_best();
            limit *= FRICTION_FACTOR;
        }
        iterate.steps += part.iterate.steps;
        guess.modes.clone_from(&part.guess.modes);
        guess.slips.clone_from(&part.guess.slips);
        initial.clone_from(&part.initial);
        self.newton_from(true, true, Weight::Balanced, Limits::NORMAL)
    }

    /// Takes the best impulse and its modes as the initial guess.
    fn start_from_best(&mut self) {
        let Coulomb { cones, guess, initial, best, modes, .. } = self;
        cones.velocity(&best.f, &mut best.v);
        guess.modes.clone_from(modes);
        guess.slips.clear();
        guess
            .slips
            .extend((0..cones.contacts).map(|i| contact_rows(&best.v, i)).map(|[_, along, across]| [along, across]));
        initial.clone_from(&best.f);
    }
}
