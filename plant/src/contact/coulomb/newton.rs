//! Semismooth Newton method for Coulomb's law, over patches and single contacts.
//!
//! Each contact is open, sticks or slides, depending on x = f − ρ v. Contacts of one link that stick do so together, as a patch. The
//! unknowns y with f = G y obey the same number of equations R v + D y = 0, where v = A f + b + ε(f − f₀), and ε is the compliance:
//!
//! | mode | condition | unknowns | equations |
//! |---|---|---|---|
//! | open | x_N ≤ 0 | – | – |
//! | sticking | \|x_F\| ≤ μ x_N | f | v = 0 |
//! | patch | sticking, with others of its link | z, f = Q z | Qᵀv = 0 |
//! | sliding | else; e = x_F/\|x_F\| | f_N along (1, μe), f⊥ along e⊥ | v_N = 0, σρ v⊥ + (1 − σ) f⊥ = 0, σ = μ x_N/\|x_F\| |
//!
//! Near a solution the modes no longer change, and the steps converge quadratically. Far from it they may diverge; the next stage of the
//! cascade then provides another start.
//!
//! # Source
//! Alart & Curnier (1991): the equations of a contact. Compliance around f₀: the proximal point method of Rockafellar (1976).

mod dependence;
mod equations;
mod linear_system;
mod min_norm;
mod modes;

use super::super::lu::Lu;
use super::super::mode::ContactMode;
use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{NEWTON_PROGRESS, SOLVED, WELL_SOLVED};
use super::iterate::{Iterate, Start, Weight};
use super::patch::{LinkContacts, Patch};
use dependence::{Dependence, Selection};
use equations::{ModeWeights, Unknown};

/// If the residual with compliance is this part of the rigid one or less [-], only the compliance remains to be undone.
const COMPLIANCE_DOMINATES: f64 = 0.1;
/// A greater rigid residual is never due to the compliance [-].
const COMPLIANT: f64 = 1e-3;
/// Proximal steps at most, which undo the compliance.
const MAX_REFINEMENTS: u32 = 4;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct PatchNewton {
    pub groups: Vec<LinkContacts>,
    contacts: Vec<ModeWeights>,
    patch: Patch,
    unknowns: Vec<Unknown>,
    response: Vec<f64>,
    /// Matrix of the equations, column by column.
    matrix: Vec<f64>,
    factor: Lu,
    right: Vec<f64>,
    dependence: Dependence,
    /// ε.
    compliance: f64,
    /// f₀, the centre of the proximal step; and G y, the impulse before it is distributed over patches.
    prox_centre: Vec<f64>,
    undistributed: Vec<f64>,
    /// The impulse before the present step.
    saved: Vec<f64>,
    change: Vec<f64>,
    pub solution: Iterate,
    /// The modes before contacts without load were activated.
    modes_before: Vec<ModeWeights>,
    /// A patch was outside its cones, or moves; see [`LinkContacts::fails`].
    failed: bool,
}

impl PatchNewton {
    /// Takes a problem: groups its contacts by link.
    pub fn set_problem(&mut self, cones: &RoundCones) {
        self.groups.clear();
        for i in 0..cones.contacts {
            match self.groups.last_mut() {
                Some(group) if cones.link[i] == cones.link[i - 1] => group.end = i + 1,
                _ => self.groups.push(LinkContacts { first: i, end: i + 1, ..LinkContacts::default() }),
            }
        }
        self.patch.reset(cones.contacts);
    }

    /// The modes of the last run.
    pub fn modes(&self) -> impl Iterator<Item = ContactMode> + '_ {
        self.contacts.iter().map(|contact| contact.mode)
    }

    /// Iterates from the present impulse to the solution. A patch that does not hold is released. A selection that the guess needs stays as long as
    /// the residual falls. False if it does not converge.
    pub fn run(&mut self, cones: &RoundCones, start: Start, iterate: &mut Iterate) -> bool {
        let Start { guess, weight, limits, .. } = start;
        self.prepare(cones, start, iterate);
        let (mut refined, mut least, mut least_step) = (0, f64::INFINITY, 0);
        let mut selection = Selection::Any;
        for step in 0.. {
            if limits.are_reached(step, least_step) {
                return false;
            }
            match guess {
                Some(guess) if step == 0 => {
                    self.apply_guess(cones, guess, iterate);
                    selection = self.needed_selection(cones);
                }
                _ => self.classify(cones, weight, iterate),
            }
            iterate.steps += 1;
            self.saved.clone_from(&iterate.f);
            if !self.solve(cones, selection, &mut iterate.f) {
                return false;
            }
            self.undistributed.clone_from(&iterate.f);
            self.distribute(cones, &mut iterate.f);
            if self.failed {
                selection = Selection::Any;
                self.release_failed();
                iterate.f.clone_from(&self.undistributed);
                self.velocity(cones, iterate);
                continue;
            }
            cones.velocity(&iterate.f, &mut iterate.v);
            iterate.error = cones.residual(&iterate.f, &iterate.v);
            if iterate.error <= SOLVED {
                self.refine(cones, iterate);
                if selection == Selection::Any || self.has_idle_contacts(cones, iterate) {
                    self.use_min_norm_pressure(cones, iterate);
                }
                return true;
            }
            let rigid = iterate.error;
            if rigid < NEWTON_PROGRESS * least {
                (least, least_step) = (rigid, step);
            } else {
                selection = Selection::Any;
            }
            if weight != Weight::Mass {
                self.prox_centre.clone_from(&self.undistributed);
            }
            self.add_compliance(&mut iterate.v);
            if self.patches_move(cones, iterate) {
                self.release_failed();
                continue;
            }
            if rigid <= COMPLIANT && cones.residual(&iterate.f, &iterate.v) <= COMPLIANCE_DOMINATES * rigid {
                // solved except for the compliance
                if refined == MAX_REFINEMENTS {
                    return false;
                }
                refined += 1;
                self.prox_centre.clone_from(&self.undistributed);
            }
        }
        false
    }

    /// Sets the state before the first step.
    fn prepare(&mut self, cones: &RoundCones, start: Start, iterate: &mut Iterate) {
        let Start { patches, weight, limits, .. } = start;
        self.compliance = limits.compliance;
        self.contacts.clear();
        self.contacts.resize(cones.contacts, ModeWeights::default());
        self.groups.iter_mut().for_each(|group| (group.sticks, group.may_stick) = (false, patches));
        self.prox_centre.clone_from(&iterate.f);
        if weight == Weight::Mass && !limits.compliance_from_start {
            self.prox_centre.fill(0.0);
        }
        self.undistributed.clone_from(&iterate.f);
        self.velocity(cones, iterate);
    }

    /// v = A f + b + ε(G y − f₀).
    fn velocity(&self, cones: &RoundCones, Iterate { f, v, .. }: &mut Iterate) {
        cones.velocity(f, v);
        self.add_compliance(v);
    }

    /// v + ε(G y − f₀).
    fn add_compliance(&self, v: &mut [f64]) {
        for ((v, y), prox_centre) in v.iter_mut().zip(&self.undistributed).zip(&self.prox_centre) {
            *v += self.compliance * (y - prox_centre);
        }
    }

    /// Distributes the impulses of patches over their contacts; marks patches for which that fails.
    fn distribute(&mut self, cones: &RoundCones, f: &mut [f64]) {
        let PatchNewton { groups, contacts, patch, failed, saved, .. } = self;
        *failed = false;
        for group in groups {
            group.fails =
                group.sticks && !patch.distribute(cones, group, |i| contacts[i].mode == ContactMode::Patch, saved, f);
            *failed |= group.fails;
        }
    }

    /// Whether a patch moves at the solution. That happens if points of a link land from different heights and their conditions contradict
    /// each other. Marks these patches.
    fn patches_move(&mut self, cones: &RoundCones, Iterate { v, .. }: &Iterate) -> bool {
        let PatchNewton { groups, contacts, failed, .. } = self;
        for group in groups.iter_mut().filter(|group| group.sticks) {
            let members = (group.first..group.end).filter(|&i| contacts[i].mode == ContactMode::Patch);
            let mut speed =
                members.map(|i| contact_rows(v, i).iter().fold(0.0, |most: f64, v| most.max(v.abs())) / cones.speed(i));
            group.fails = speed.any(|speed| speed > WELL_SOLVED);
            *failed |= group.fails;
        }
        *failed
    }

    /// Releases the marked patches for the rest of the run: each of their contacts has its own mode.
    fn release_failed(&mut self) {
        for group in self.groups.iter_mut().filter(|group| group.fails) {
            (group.sticks, group.may_stick, group.fails) = (false, false, false);
        }
    }
}
