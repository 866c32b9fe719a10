//! Unknowns and equations of the Newton method, after the table in [`super`]. The columns of G map unknowns to impulses. The rows of R map
//! velocities to equations.

use super::super::super::mode::ContactMode;
use super::super::super::round_cones::{RoundCones, contact_rows};
use super::super::patch::{LINK_DOFS, LinkContacts, Patch};

/// Mode of a contact, and the weights of its equations.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ModeWeights {
    pub mode: ContactMode,
    /// Direction of friction, e.
    pub along: [f64; 2],
    /// Weights σρ of v⊥ and 1 − σ of f⊥.
    pub slip_weight: f64,
    pub friction_weight: f64,
}

/// One unknown, with its column of G and its row of R.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unknown {
    Patch { group: usize, column: usize },
    Sticking { contact: usize, row: usize },
    ConeEdge(usize),
    Transverse(usize),
}

/// Normal part of the unit vector (1, μe) along the edge of a cone.
pub(super) fn cone_edge(friction: f64) -> f64 {
    1.0 / (1.0 + friction * friction).sqrt()
}

/// G and R.
pub(super) struct Equations<'a> {
    pub cones: &'a RoundCones,
    pub groups: &'a [LinkContacts],
    pub contacts: &'a [ModeWeights],
    pub patch: &'a Patch,
}

impl Equations<'_> {
    /// Calls `entry` for each nonzero of a column of G.
    #[inline(always)]
    pub fn scatter(&self, unknown: Unknown, mut entry: impl FnMut(usize, f64)) {
        match unknown {
            Unknown::Patch { group, column } => {
                let group = &self.groups[group];
                for i in (group.first..group.end).filter(|&i| self.contacts[i].mode == ContactMode::Patch) {
                    (0..3).for_each(|k| entry(3 * i + k, self.patch.basis[i][k][column]));
                }
            }
            Unknown::Sticking { contact, row } => entry(3 * contact + row, 1.0),
            Unknown::ConeEdge(i) => {
                let (mu, [a, b]) = (self.cones.friction[i], self.contacts[i].along);
                let unit = cone_edge(mu);
                [unit, unit * mu * a, unit * mu * b]
                    .into_iter()
                    .enumerate()
                    .for_each(|(k, weight)| entry(3 * i + k, weight));
            }
            Unknown::Transverse(i) => {
                let [a, b] = self.contacts[i].along;
                entry(3 * i + 1, -b);
                entry(3 * i + 2, a);
            }
        }
    }

    /// f + G y.
    pub fn add(&self, unknowns: &[Unknown], y: &[f64], f: &mut [f64]) {
        for (unknown, y) in unknowns.iter().zip(y) {
            self.scatter(*unknown, |row, weight| f[row] += weight * y);
        }
    }

    /// R times a vector of contact rows. All rows of a patch are computed at its first unknown.
    pub fn gather(&self, unknowns: &[Unknown], rows: &[f64], values: &mut Vec<f64>) {
        for unknown in unknowns {
            match *unknown {
                Unknown::Patch { group, column: 0 } => {
                    let (group, mut sums) = (&self.groups[group], [0.0; LINK_DOFS]);
                    for i in (group.first..group.end).filter(|&i| self.contacts[i].mode == ContactMode::Patch) {
                        for (weights, x) in self.patch.basis[i].iter().zip(contact_rows(rows, i)) {
                            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * x);
                        }
                    }
                    values.extend_from_slice(&sums[..group.rank]);
                }
                Unknown::Patch { .. } => {}
                Unknown::Sticking { contact, row } => values.push(rows[3 * contact + row]),
                Unknown::ConeEdge(i) => values.push(rows[3 * i]),
                Unknown::Transverse(i) => {
                    let ModeWeights { along: [a, b], slip_weight, .. } = self.contacts[i];
                    values.push(slip_weight * (a * rows[3 * i + 2] - b * rows[3 * i + 1]));
                }
            }
        }
    }
}
