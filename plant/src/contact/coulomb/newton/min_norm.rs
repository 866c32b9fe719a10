//! Normal impulses of least norm, for links with more active contacts than independent normal directions.
//!
//! Four or more slipping contacts of a rigid link have normal impulses that A cannot tell apart. These impulses differ in their friction
//! only. Of them, the method takes those of least norm. It adds the rows (1 − N Nᵀ) f_N = 0 to the equations, where N is an orthonormal
//! basis of the range of A for the normals.

use super::super::super::mode::ContactMode;
use super::super::super::round_cones::RoundCones;
use super::super::super::tolerance::{SOLVED, UNCHANGED};
use super::super::iterate::{Iterate, Weight};
use super::equations::{Equations, Unknown};
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

    /// Takes the solution whose normal impulses have the least norm, if it obeys the law as well.
    pub(super) fn use_min_norm_pressure(&mut self, cones: &RoundCones, iterate: &mut Iterate) {
        if !self.is_pressure_redundant(cones) {
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
            false => iterate.copy(&self.solution),
        }
    }
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
            let normals = || {
                unknowns.iter().enumerate().filter_map(|(place, unknown)| match *unknown {
                    Unknown::ConeEdge(i) | Unknown::Sticking { contact: i, row: 0 } if contacts.contains(&i) => {
                        Some((place, i))
                    }
                    _ => None,
                })
            };
            for (column, i) in normals() {
                for (row, k) in normals() {
                    let projection: f64 =
                        self.patch.basis[i][0].iter().zip(self.patch.basis[k][0]).map(|(a, b)| a * b).sum();
                    matrix[column * unknowns.len() + row] += if i == k { 1.0 } else { 0.0 } - projection;
                }
            }
        }
    }
}
