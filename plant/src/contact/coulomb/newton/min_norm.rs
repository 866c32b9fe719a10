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
use super::super::super::tolerance::{NO_DIRECTION, SOLVED, UNCHANGED};
use super::super::iterate::{Iterate, Weight};
use super::equations::{Equations, ModeWeights, Unknown, cone_edge};
use super::{MAX_REFINEMENTS, PatchNewton};

impl PatchNewton {
    /// Whether a link without a patch has more active contacts than independent normal directions.
    pub(super) fn is_pressure_redundant(&mut self, cones: &RoundCones) -> bool {
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

    /// A contact of a link without a patch that carries no load and slides without leaving the ground.
    pub(super) fn idle_contact(&self, cones: &RoundCones, iterate: &Iterate) -> Option<usize> {
        let mut sliding = self.groups.iter().filter(|group| !group.sticks).flat_map(|group| group.first..group.end);
        sliding.find(|&i| self.contacts[i].mode == ContactMode::Open && is_idle(cones, i, iterate))
    }

    /// Lets these contacts carry load: they slide against their velocity, and their impulse is an unknown.
    fn activate_idle_contacts(&mut self, cones: &RoundCones, iterate: &Iterate) {
        while let Some(i) = self.idle_contact(cones, iterate) {
            let [_, along, across] = contact_rows(&iterate.v, i);
            let speed = norm(along, across);
            self.contacts[i] = ModeWeights::sliding_along([along / speed, across / speed]);
        }
    }

    /// Takes the solution whose normal impulses have the least norm, if it obeys the law as well.
    pub(super) fn use_min_norm_pressure(&mut self, cones: &RoundCones, iterate: &mut Iterate) {
        self.modes_before.clone_from(&self.contacts);
        self.activate_idle_contacts(cones, iterate);
        if !self.is_pressure_redundant(cones) {
            self.contacts.clone_from(&self.modes_before);
            return;
        }
        self.solution.copy(iterate);
        for _ in 0..MAX_REFINEMENTS {
            self.saved.clone_from(&iterate.f);
            self.failed = !self.solve(cones, true, &mut iterate.f);
            if self.failed {
                break;
            }
            self.undistributed.clone_from(&iterate.f);
            self.distribute(cones, &mut iterate.f);
            cones.velocity(&iterate.f, &mut iterate.v);
            iterate.error = cones.residual(&iterate.f, &iterate.v);
            let changes = iterate
                .f
                .iter()
                .zip(&self.saved)
                .any(|(f, saved)| (f - saved).abs() > UNCHANGED * cones.magnitude(&iterate.f));
            if self.failed || !changes {
                break;
            }
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

/// Whether a contact slides along the ground: it neither approaches nor leaves it, up to the tolerance of a solution.
fn is_idle(cones: &RoundCones, i: usize, Iterate { v, .. }: &Iterate) -> bool {
    let ([normal, along, across], least) = (contact_rows(v, i), SOLVED * cones.speed(i));
    normal.abs() <= least && norm(along, across) > NO_DIRECTION * cones.speed(i)
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
