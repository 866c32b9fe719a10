//! The evenest pressure, where one link's contacts push in more ways than the link can move.
//!
//! More than three contacts of a rigid link that slip have pressures which A cannot tell apart. They move nothing but by their friction, so of
//! them the least norm is asked for: rows of (1 − N Nᵀ) f_N = 0 are added, N an orthonormal basis of the pressures that A can feel.

use super::super::super::round_cones::RoundCones;
use super::super::super::tolerance::{SOLVED, UNCHANGED};
use super::super::{ContactMode, Iterate};
use super::equations::{Equations, Unknown};
use super::{MAX_REFINEMENTS, PatchNewton};

impl PatchNewton {
    /// Whether a link's contacts that do not stick together push in more ways than it can move.
    pub(super) fn is_pressure_redundant(&mut self, cones: &RoundCones) -> bool {
        let PatchNewton { groups, contacts, patch, .. } = self;
        let mut redundant = false;
        for group in groups.iter_mut().filter(|group| !group.sticks) {
            let pushes = |i: usize| contacts[i].mode != ContactMode::Open;
            let pushing = (group.first..group.end).filter(|&i| pushes(i)).count();
            if pushing > 1 {
                patch.find_basis(cones, group, 1, pushes);
                redundant |= group.rank < pushing;
            }
        }
        redundant
    }

    /// Takes the solution with the evenest pressure, if it obeys the law too.
    pub(super) fn use_min_norm_pressure(&mut self, cones: &RoundCones, iterate: &mut Iterate) {
        if !self.is_pressure_redundant(cones) {
            return;
        }
        self.solution.copy(iterate);
        for _ in 0..MAX_REFINEMENTS {
            self.saved.clone_from(&iterate.f);
            self.failed = u32::from(!self.solve(cones, true, &mut iterate.f));
            if self.failed != 0 {
                break;
            }
            self.undistributed.clone_from(&iterate.f);
            self.distribute(cones, &mut iterate.f);
            cones.velocity(&iterate.f, &mut iterate.v);
            iterate.error = cones.residual(&iterate.f, &iterate.v);
            let moves = iterate
                .f
                .iter()
                .zip(&self.saved)
                .any(|(f, saved)| (f - saved).abs() > UNCHANGED * cones.magnitude(&iterate.f));
            if self.failed != 0 || !moves {
                break;
            }
            self.classify(cones, iterate);
        }
        match self.failed == 0 && iterate.error <= SOLVED {
            true => self.refine(cones, iterate),
            false => iterate.copy(&self.solution),
        }
    }
}

impl Equations<'_> {
    /// Adds that the pressure of a link without a patch is the evenest: of normal impulses that A cannot tell apart there are none. They
    /// move nothing but by their friction, and would else be quotients of roundings.
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
