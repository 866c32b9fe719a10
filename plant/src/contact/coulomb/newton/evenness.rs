//! The evenest pressure, where one link's contacts push in more ways than the link can move.
//!
//! More than three contacts of a rigid link that slip have pressures which A cannot tell apart. They move nothing but by their friction, so of
//! them the least norm is asked for: rows of (1 − N Nᵀ) f_N = 0 are added, N an orthonormal basis of the pressures that A can feel.

use super::super::super::round::Round;
use super::super::super::tolerance::SOLVED;
use super::super::{Iterate, Kind};
use super::equations::{Equations, Unknown};
use super::{Newton, REFINEMENTS};

/// A change of the impulse up to this part of the greatest is rounding [-].
const STILL: f64 = 1e-14;

impl Newton {
    /// Whether a link's contacts that do not stick together push in more ways than it can move.
    pub(super) fn has_spare_pressure(&mut self, round: &Round) -> bool {
        let Newton { groups, contacts, patch, .. } = self;
        let mut spare = false;
        for group in groups.iter_mut().filter(|group| !group.sticks) {
            let pushes = |i: usize| contacts[i].kind != Kind::Open;
            let pushing = (group.first..group.end).filter(|&i| pushes(i)).count();
            if pushing > 1 {
                patch.find_basis(round, group, 1, pushes);
                spare |= group.rank < pushing;
            }
        }
        spare
    }

    /// Takes the solution with the evenest pressure, if it obeys the law too.
    pub(super) fn press_evenly(&mut self, round: &Round, iterate: &mut Iterate) {
        if !self.has_spare_pressure(round) {
            return;
        }
        self.found.copy(iterate);
        for _ in 0..REFINEMENTS {
            self.kept.clone_from(&iterate.f);
            self.failed = u32::from(!self.solve(round, true, &mut iterate.f));
            if self.failed != 0 {
                break;
            }
            self.linear.clone_from(&iterate.f);
            self.spread(round, &mut iterate.f);
            round.velocity(&iterate.f, &mut iterate.v);
            iterate.error = round.residual(&iterate.f, &iterate.v);
            let moves =
                iterate.f.iter().zip(&self.kept).any(|(f, kept)| (f - kept).abs() > STILL * round.reach(&iterate.f));
            if self.failed != 0 || !moves {
                break;
            }
            self.classify(round, iterate);
        }
        match self.failed == 0 && iterate.error <= SOLVED {
            true => self.refine(round, iterate),
            false => iterate.copy(&self.found),
        }
    }
}

impl Equations<'_> {
    /// Adds that the pressure of a link without a patch is the evenest: of normal impulses that A cannot tell apart there are none. They
    /// move nothing but by their friction, and would else be quotients of roundings.
    pub(super) fn press_evenly(&self, unknowns: &[Unknown], matrix: &mut [f64]) {
        for group in self.groups.iter().filter(|group| !group.sticks) {
            let contacts = group.first..group.end;
            if contacts.clone().filter(|&i| self.contacts[i].kind != Kind::Open).count() == group.rank {
                continue;
            }
            let normals = || {
                unknowns.iter().enumerate().filter_map(|(place, unknown)| match *unknown {
                    Unknown::Along(i) | Unknown::Sticks { contact: i, row: 0 } if contacts.contains(&i) => {
                        Some((place, i))
                    }
                    _ => None,
                })
            };
            for (column, i) in normals() {
                for (row, k) in normals() {
                    let told_apart: f64 =
                        self.patch.basis[i][0].iter().zip(self.patch.basis[k][0]).map(|(a, b)| a * b).sum();
                    matrix[column * unknowns.len() + row] += if i == k { 1.0 } else { 0.0 } - told_apart;
                }
            }
        }
    }
}
