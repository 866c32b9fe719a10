//! Semismooth Newton on Coulomb's law, over patches and contacts.
//!
//! Each contact is open, sticks or slides, as x = f − ρ v says; contacts of one link that stick do so together, as a patch. That gives
//! unknowns G y = f and as many equations R v + D y = 0, with v = A f + b + ε(f − f₀), ε the compliance:
//!
//! | contact | when | unknowns | equations |
//! |---|---|---|---|
//! | open | x_N ≤ 0 | – | – |
//! | sticks | \|x_F\| ≤ μ x_N | f | v = 0 |
//! | patch | sticks, as another of its link | z, f = Q z | Qᵀv = 0 |
//! | slides | else; e = x_F/\|x_F\| | f_N along (1, μe), f⊥ along e⊥ | v_N = 0, σρ v⊥ + (1 − σ) f⊥ = 0, σ = μ x_N/\|x_F\| |
//!
//! Near a solution the kinds no longer change and the steps converge quadratically. Far from it they need not: then there is another start.
//!
//! # Source
//! Alart & Curnier (1991): the equations of a contact. Compliance around f₀: the proximal point method of Rockafellar (1976).

mod equations;
mod evenness;
mod kinds;

use super::super::pivoted::Pivoted;
use super::super::round::{Round, part};
use super::super::tolerance::{COMPLIANCE, SOLVED};
use super::patch::{Group, Patch};
use super::{Iterate, Kind, Start};
use equations::{Equations, Unknown};
use kinds::Contact;

/// Steps at most; from a good start it takes one to four.
const STEPS: u32 = 12;
/// Steps in which a patch may be outside its cones before it is given up.
const PATIENCE: u32 = 4;
/// A residual up to this is rounding: another step would change nothing [-].
const EXACT: f64 = 2e-15;
/// Solutions at most that undo the compliance.
const REFINEMENTS: u32 = 4;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Newton {
    pub groups: Vec<Group>,
    contacts: Vec<Contact>,
    patch: Patch,
    unknowns: Vec<Unknown>,
    response: Vec<f64>,
    /// The equations, column by column.
    matrix: Vec<f64>,
    factor: Pivoted,
    right: Vec<f64>,
    /// The impulse that the compliance acts around, f₀, and G y before patches are spread.
    around: Vec<f64>,
    linear: Vec<f64>,
    kept: Vec<f64>,
    change: Vec<f64>,
    found: Iterate,
    /// Patches that the last run found outside their cones, as bits of their groups.
    failed: u32,
}

impl Newton {
    /// Begins with a problem: its contacts by link.
    pub fn begin(&mut self, round: &Round) {
        self.groups.clear();
        for i in 0..round.contacts {
            match self.groups.last_mut() {
                Some(group) if round.link[i] == round.link[i - 1] => group.end = i + 1,
                _ => self.groups.push(Group { first: i, end: i + 1, ..Group::default() }),
            }
        }
        self.patch.begin(round.contacts);
    }

    /// The kinds of the last run.
    pub fn kinds(&self) -> impl Iterator<Item = Kind> + '_ {
        self.contacts.iter().map(|contact| contact.kind)
    }

    /// From the present impulse to the solution. The groups of `free` do not stick as a patch. False if it does not get there.
    pub fn run(&mut self, round: &Round, free: u32, start: Option<&Start>, iterate: &mut Iterate) -> bool {
        self.contacts.clear();
        self.contacts.resize(round.contacts, Contact::default());
        for (g, group) in self.groups.iter_mut().enumerate() {
            (group.sticks, group.may) = (false, free >> g.min(31) & 1 == 0);
        }
        self.around.clear();
        self.around.resize(iterate.f.len(), 0.0);
        self.linear.clone_from(&iterate.f);
        self.velocity(round, iterate);
        let (mut outside, mut refined) = (0, 0);
        for step in 0..STEPS {
            match start {
                Some(start) if step == 0 => self.recall(round, start, iterate),
                _ => self.classify(round, iterate),
            }
            iterate.steps += 1;
            self.failed = 0;
            let evenly = step == 0 && start.is_some() && self.has_spare_pressure(round);
            if !self.solve(round, evenly, &mut iterate.f) {
                return false;
            }
            self.linear.clone_from(&iterate.f);
            self.spread(round, &mut iterate.f);
            if self.failed != 0 {
                outside += 1;
                let moves = |contact: &Contact| matches!(contact.kind, Kind::Sticks | Kind::Slides);
                if outside >= PATIENCE || !self.contacts.iter().any(moves) {
                    return false;
                }
                iterate.f.clone_from(&self.linear);
                self.velocity(round, iterate);
                continue;
            }
            round.velocity(&iterate.f, &mut iterate.v);
            iterate.error = round.residual(&iterate.f, &iterate.v);
            if iterate.error <= SOLVED {
                self.refine(round, iterate);
                if !evenly || iterate.error > EXACT {
                    self.press_evenly(round, iterate);
                }
                return true;
            }
            let rigid = iterate.error;
            self.velocity(round, iterate);
            if self.patches_move(round, iterate) {
                return false;
            }
            if round.residual(&iterate.f, &iterate.v) <= 0.1 * rigid {
                // solved but for what the compliance moves
                if refined == REFINEMENTS {
                    return false;
                }
                refined += 1;
                self.around.clone_from(&self.linear);
            }
        }
        false
    }

    /// v = A f + b + ε(G y − f₀).
    fn velocity(&self, round: &Round, Iterate { f, v, .. }: &mut Iterate) {
        round.velocity(f, v);
        for ((v, y), around) in v.iter_mut().zip(&self.linear).zip(&self.around) {
            *v += COMPLIANCE * (y - around);
        }
    }

    /// One solution of the equations, if asked for that with the evenest pressure; writes f = G y.
    fn solve(&mut self, round: &Round, evenly: bool, f: &mut [f64]) -> bool {
        let Newton { groups, contacts, patch, unknowns, response, matrix, factor, right, around, .. } = self;
        unknowns.clear();
        for (g, group) in groups.iter_mut().enumerate() {
            if group.sticks {
                patch.find_basis(round, group, 3, |i| contacts[i].kind == Kind::Patch);
                unknowns.extend((0..group.rank).map(|column| Unknown::Patch { group: g, column }));
            } else if evenly {
                patch.find_basis(round, group, 1, |i| contacts[i].kind != Kind::Open);
            }
            for (contact, own) in (group.first..).zip(&contacts[group.first..group.end]) {
                match own.kind {
                    Kind::Open | Kind::Patch => {}
                    Kind::Sticks => unknowns.extend([0, 1, 2].map(|row| Unknown::Sticks { contact, row })),
                    Kind::Slides => unknowns.extend([Unknown::Along(contact), Unknown::Across(contact)]),
                }
            }
        }
        if unknowns.is_empty() {
            f.fill(0.0);
            return true;
        }
        let equations = Equations { round, groups: &*groups, contacts, patch: &*patch };
        let (n, m) = (unknowns.len(), f.len());
        matrix.clear();
        right.clear();
        for (place, unknown) in unknowns.iter().enumerate() {
            response.clear();
            response.resize(m, 0.0);
            equations.push(*unknown, |row, weight| {
                let a = &round.delassus[row * m..][..m];
                response.iter_mut().zip(a).for_each(|(sum, a)| *sum = a.mul_add(weight, *sum));
                response[row] += COMPLIANCE * weight;
            });
            equations.read(unknowns, response, matrix);
            if let Unknown::Across(i) = *unknown {
                matrix[place * n + place] += contacts[i].friction;
            }
        }
        if evenly {
            equations.press_evenly(unknowns, matrix);
        }
        response.clear();
        response.extend(round.drift.iter().zip(&*around).map(|(b, around)| COMPLIANCE * around - b));
        equations.read(unknowns, response, right);
        if !factor.factorize(n, matrix, 0.0) {
            return false;
        }
        factor.solve(right);
        f.fill(0.0);
        equations.add(unknowns, right, f);
        f.iter().all(|f| f.is_finite())
    }

    /// Undoes what the compliance has moved, wherever A allows, by the factor that is there; kept if the residual is less.
    fn refine(&mut self, round: &Round, iterate: &mut Iterate) {
        let Iterate { f, v, error, .. } = iterate;
        let Newton { groups, contacts, patch, unknowns, factor, right, linear, kept, change, .. } = self;
        if unknowns.is_empty() {
            return;
        }
        kept.clone_from(f);
        let equations = Equations { round, groups, contacts, patch };
        change.clear();
        equations.read(unknowns, v, change);
        for ((change, unknown), y) in change.iter_mut().zip(&*unknowns).zip(&*right) {
            *change = match *unknown {
                Unknown::Across(i) => -*change - contacts[i].friction * y,
                _ => -*change,
            };
        }
        factor.solve(change);
        f.clone_from(linear);
        equations.add(unknowns, change, f);
        self.failed = 0;
        self.spread(round, f);
        round.velocity(f, v);
        let refined = round.residual(f, v);
        if self.failed == 0 && refined < *error {
            *error = refined;
        } else {
            f.clone_from(&self.kept);
            round.velocity(f, v);
        }
    }

    /// Spreads the impulses of patches over their contacts; notes those that cannot be.
    fn spread(&mut self, round: &Round, f: &mut [f64]) {
        let Newton { groups, contacts, patch, failed, .. } = self;
        for (g, group) in groups.iter().enumerate().filter(|(_, group)| group.sticks) {
            if !patch.spread(round, group, |i| contacts[i].kind == Kind::Patch, f) {
                *failed |= 1 << g.min(31);
            }
        }
    }

    /// Whether what should stick moves all the same: points of a link that land from different heights pull it to and fro.
    fn patches_move(&mut self, round: &Round, Iterate { v, .. }: &Iterate) -> bool {
        for (g, group) in self.groups.iter().enumerate().filter(|(_, group)| group.sticks) {
            let members = (group.first..group.end).filter(|&i| self.contacts[i].kind == Kind::Patch);
            let mut speed =
                members.map(|i| part(v, i).iter().fold(0.0, |most: f64, v| most.max(v.abs())) / round.speed(i));
            if speed.any(|speed| speed > 0.5 * SOLVED) {
                self.failed |= 1 << g.min(31);
            }
        }
        self.failed != 0
    }
}
