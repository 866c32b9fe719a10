//! Normal impulses of least norm, for links with more active contacts than independent normal directions.
//!
//! Four or more slipping contacts of a rigid link have normal impulses that A cannot tell apart. These impulses differ in their friction
//! only. Of them, the method takes those of least norm, in N·s. It adds the rows (1 − N Nᵀ) S⁻² f_N = 0 to the equations, where N is an
//! orthonormal basis of the range of A for the normals, and S has the scales s of the contacts, f~ = s f.
//!
//! A contact without load that neither approaches nor leaves the ground belongs to these contacts. Without it, a box that landed on three
//! corners would slide on three of four for ever.

use super::super::super::mode::ContactMode;
use super::super::super::projection::norm;
use super::super::super::round_cones::{RoundCones, contact_rows};
use super::super::super::tolerance::{NEWTON_PROGRESS, NO_DIRECTION, SOLVED};
use super::super::iterate::{Iterate, Weight};
use super::super::patch::LinkContacts;
use super::dependence::Selection;
use super::equations::{Equations, ModeWeights, Unknown, cone_edge};
use super::{MAX_REFINEMENTS, PatchNewton};

/// Steps at most over all links. Where wheels come to roll, several of them change their modes.
const MAX_STEPS_OF_ROBOT: u32 = 12;

impl PatchNewton {
    /// Whether a link without a patch has more active contacts than independent normal directions.
    fn is_pressure_redundant(&mut self, cones: &RoundCones) -> bool {
        let PatchNewton { groups, contacts, patch, .. } = self;
        let mut redundant = false;
        for group in groups.iter_mut().filter(|group| !group.sticks) {
            let is_active = |i: usize| contacts[i].mode != ContactMode::Open;
            let active = (group.first..group.end).filter(|&i| is_active(i)).count();
            if active > 1 {
                patch.find_basis(cones, group, 1, is_active);
                redundant |= group.rank < active;
            }
        }
        redundant
    }

    /// Which selection the present modes need.
    pub(super) fn needed_selection(&mut self, cones: &RoundCones) -> Selection {
        let is_active = |own: &ModeWeights| own.mode != ContactMode::Open;
        let carries = |group: &&LinkContacts| self.contacts[group.first..group.end].iter().any(is_active);
        if self.groups.iter().filter(|group| !group.sticks).filter(carries).count() > 1 {
            self.list_unknowns(cones, Selection::Any);
            let PatchNewton { groups, contacts, patch, unknowns, dependence, .. } = self;
            let equations = Equations { cones, groups, contacts, patch };
            dependence.find(&equations, unknowns);
            if dependence.joins_links(&equations) {
                return Selection::OfRobot;
            }
        }
        if self.is_pressure_redundant(cones) { Selection::OfLinks } else { Selection::Any }
    }

    /// Whether a contact is idle: see [`idle_contacts`].
    pub(super) fn has_idle_contacts(&self, cones: &RoundCones, iterate: &Iterate) -> bool {
        idle_contacts(cones, &self.groups, &self.contacts, iterate).next().is_some()
    }

    /// Takes the solution whose normal impulses have the least norm, if it obeys the law as well.
    pub(super) fn use_min_norm_pressure(&mut self, cones: &RoundCones, iterate: &mut Iterate) {
        self.modes_before.clone_from(&self.contacts);
        for (i, mode) in idle_contacts(cones, &self.groups, &self.modes_before, iterate) {
            self.contacts[i] = mode;
        }
        let selection = self.needed_selection(cones);
        if selection == Selection::Any {
            self.contacts.clone_from(&self.modes_before);
            return;
        }
        self.solution.copy(iterate);
        let steps = if selection == Selection::OfRobot { MAX_STEPS_OF_ROBOT } else { MAX_REFINEMENTS };
        let mut before = f64::INFINITY;
        for _ in 0..steps {
            iterate.steps += 1;
            self.saved.clone_from(&iterate.f);
            self.failed = !self.solve(cones, selection, &mut iterate.f);
            if self.failed {
                break;
            }
            self.undistributed.clone_from(&iterate.f);
            self.distribute(cones, &mut iterate.f);
            cones.velocity(&iterate.f, &mut iterate.v);
            iterate.error = cones.residual(&iterate.f, &iterate.v);
            let converged = iterate.error <= SOLVED && iterate.error > NEWTON_PROGRESS * before;
            if self.failed || converged {
                break;
            }
            before = iterate.error;
            self.classify(cones, Weight::Mass, iterate);
        }
        match !self.failed && iterate.error <= SOLVED {
            true => self.refine(cones, iterate),
            false => {
                iterate.copy(&self.solution);
                self.contacts.clone_from(&self.modes_before);
            }
        }
    }
}

/// Contacts outside patches that carry no load and slide along the ground, neither approaching nor leaving it, with the modes in which they may
/// carry load.
fn idle_contacts<'a>(
    cones: &'a RoundCones,
    groups: &'a [LinkContacts],
    contacts: &'a [ModeWeights],
    Iterate { v, .. }: &'a Iterate,
) -> impl Iterator<Item = (usize, ModeWeights)> + 'a {
    let free = groups.iter().filter(|group| !group.sticks).flat_map(|group| group.first..group.end);
    free.filter(|&i| contacts[i].mode == ContactMode::Open).filter_map(move |i| {
        let [normal, along, across] = contact_rows(v, i);
        let speed = norm(along, across);
        let slides = normal.abs() <= SOLVED * cones.speed(i) && speed > NO_DIRECTION * cones.speed(i);
        slides.then(|| (i, ModeWeights::sliding_along([along / speed, across / speed])))
    })
}

impl Equations<'_> {
    /// Adds the condition that the normal impulses of a link without a patch have no part in the null space of A. That part affects the
    /// motion through friction only, and would else be a quotient of rounding errors.
    pub(super) fn use_min_norm_pressure(&self, unknowns: &[Unknown], matrix: &mut [f64]) {
        for group in self.groups.iter().filter(|group| !group.sticks) {
            let contacts = group.first..group.end;
            if contacts.clone().filter(|&i| self.contacts[i].mode != ContactMode::Open).count() == group.rank {
                continue;
            }
            let unit = self.cones.scale[group.first]; // for rows of about 1
            let normals = || {
                unknowns.iter().enumerate().filter_map(|(place, unknown)| match *unknown {
                    Unknown::ConeEdge(i) if contacts.contains(&i) => {
                        Some((place, i, cone_edge(self.cones.friction[i])))
                    }
                    Unknown::Sticking { contact: i, row: 0 } if contacts.contains(&i) => Some((place, i, 1.0)),
                    _ => None,
                })
            };
            for (column, i, normal) in normals() {
                for (row, k, _) in normals() {
                    let projection: f64 =
                        self.patch.basis[i][0].iter().zip(self.patch.basis[k][0]).map(|(a, b)| a * b).sum();
                    let remainder = if i == k { 1.0 } else { 0.0 } - projection;
                    matrix[column * unknowns.len() + row] += remainder * normal * (unit / self.cones.scale[i]).powi(2);
                }
            }
        }
    }
}
