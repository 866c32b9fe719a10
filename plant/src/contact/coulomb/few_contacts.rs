//! Few contacts: solves the problem over a selection of contacts, and exchanges contacts until no other one enters the ground.
//!
//! ```text
//!   f = 0, nothing is selected
//!   repeat   deselect the contacts without impulse, and select the one that enters the ground fastest
//!            f: solution over the selected contacts, the others without impulse;
//!               if there is none: over all but one of them, such that this one does not enter the ground
//! ```
//!
//! A rigid body has six degrees of freedom, so three or four corners carry a plate on 64. Corners that are above the ground by a nanometre may
//! approach it by as much, and corners below it need not rise. To the plate the ground is then bent by a nanometre, and methods over all
//! contacts do not find the corners that press. Here a corner without impulse shows by its velocity that it is missing. A solution over the
//! selected contacts solves the whole problem if no other contact enters the ground.
//!
//! # Source
//! Exchange methods, for programs with many inequalities: Hettich & Kortanek, *Semi-infinite programming* (1993).

use super::super::mode::ContactMode;
use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{MAX_EXCHANGES, SOLVED};
use super::Coulomb;
use super::iterate::{Iterate, Limits, Weight};

impl Coulomb {
    /// Solves over a selection of contacts until no other contact enters the ground. Newton's method over all contacts then distributes the
    /// pressure.
    pub(super) fn few_contacts(&mut self) -> bool {
        self.selected.clear();
        self.iterate.f.fill(0.0);
        for _ in 0..MAX_EXCHANGES {
            self.cones.velocity(&self.iterate.f, &mut self.iterate.v);
            if self.cones.residual(&self.iterate.f, &self.iterate.v) <= SOLVED {
                self.initial.clone_from(&self.iterate.f);
                if !self.newton_from(true, true, Weight::Balanced, Limits::NORMAL) {
                    self.iterate.f.clone_from(&self.initial);
                    self.keep_best(true);
                }
                return true;
            }
            if !(self.exchange() && (self.solve_selection() || self.leave_one_out())) {
                return false;
            }
        }
        false
    }

    /// Deselects the contacts without impulse, and selects the contact that enters the ground fastest. False if none does.
    fn exchange(&mut self) -> bool {
        let Coulomb { cones, selected, iterate: Iterate { f, v, .. }, .. } = self;
        selected.retain(|&i| f[3 * i] > 0.0);
        let speed = |i: usize| v[3 * i] / cones.speed(i);
        let others = (0..cones.contacts).filter(|i| !selected.contains(i) && v[3 * i] < 0.0);
        let fastest = others.min_by(|&i, &k| speed(i).total_cmp(&speed(k)));
        selected.extend(fastest);
        selected.sort_unstable(); // contacts of one link stay together
        fastest.is_some()
    }

    /// Solves over all but one of the selected contacts. False if none of them can be left out.
    fn leave_one_out(&mut self) -> bool {
        for k in 0..self.selected.len() {
            let left = self.selected.remove(k);
            if self.solve_selection() {
                self.cones.velocity(&self.iterate.f, &mut self.iterate.v);
                if self.iterate.v[3 * left] >= 0.0 {
                    return true;
                }
            }
            self.selected.insert(k, left);
        }
        false
    }

    /// Solves over the selected contacts, without memory, by Newton's method and interior points. False if they fail.
    fn solve_selection(&mut self) -> bool {
        let Coulomb { cones, selected, part, guess, iterate, .. } = self;
        let part = part.get_or_insert_default();
        part.begin_selection(cones, selected);
        let solved = part.newton_from_memory(Limits::NORMAL) || part.interior_points();
        part.cones.velocity(&part.best.f, &mut part.best.v);
        iterate.steps += part.iterate.steps;
        iterate.f.fill(0.0);
        guess.modes.fill(ContactMode::Open);
        guess.slips.fill([0.0; 2]);
        for (k, &i) in selected.iter().enumerate() {
            iterate.f[3 * i..][..3].copy_from_slice(&contact_rows(&part.best.f, k));
            guess.modes[i] = part.modes[k];
            let [_, along, across] = contact_rows(&part.best.v, k);
            guess.slips[i] = [along, across];
        }
        solved
    }

    /// Takes the problem over the selected contacts, and zero impulse as the initial guess.
    pub(super) fn begin_selection(&mut self, all: &RoundCones, selected: &[usize]) {
        let Coulomb { cones, newton, guess, initial, .. } = self;
        all.select(selected, cones);
        newton.set_problem(cones);
        guess.modes.clear();
        guess.modes.resize(cones.contacts, ContactMode::Open);
        guess.slips.clear();
        guess.slips.resize(cones.contacts, [0.0; 2]);
        initial.clear();
        initial.resize(3 * cones.contacts, 0.0);
        self.begin();
    }
}
