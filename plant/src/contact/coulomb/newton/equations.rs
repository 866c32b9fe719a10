//! The unknowns of Newton's method as columns of G, which says where each pushes, and their equations as rows of R, which says where each
//! reads. The table is that of [`super`].

use super::super::super::round::{Round, part};
use super::super::Kind;
use super::super::patch::{Group, MOST, Patch};
use super::kinds::Contact;

/// One unknown: where it pushes, and where its equation reads.
#[derive(Clone, Copy, Debug)]
pub(super) enum Unknown {
    Patch { group: usize, column: usize },
    Sticks { contact: usize, row: usize },
    Along(usize),
    Across(usize),
}

/// G and R by their unknowns.
pub(super) struct Equations<'a> {
    pub round: &'a Round,
    pub groups: &'a [Group],
    pub contacts: &'a [Contact],
    pub patch: &'a Patch,
}

impl Equations<'_> {
    /// Entries of a column of G.
    #[inline(always)]
    pub fn push(&self, unknown: Unknown, mut entry: impl FnMut(usize, f64)) {
        match unknown {
            Unknown::Patch { group, column } => {
                let group = &self.groups[group];
                for i in (group.first..group.end).filter(|&i| self.contacts[i].kind == Kind::Patch) {
                    (0..3).for_each(|k| entry(3 * i + k, self.patch.basis[i][k][column]));
                }
            }
            Unknown::Sticks { contact, row } => entry(3 * contact + row, 1.0),
            Unknown::Along(i) => {
                let (mu, [a, b]) = (self.round.friction[i], self.contacts[i].along);
                let unit = 1.0 / (1.0 + mu * mu).sqrt();
                [unit, unit * mu * a, unit * mu * b]
                    .into_iter()
                    .enumerate()
                    .for_each(|(k, weight)| entry(3 * i + k, weight));
            }
            Unknown::Across(i) => {
                let [a, b] = self.contacts[i].along;
                entry(3 * i + 1, -b);
                entry(3 * i + 2, a);
            }
        }
    }

    /// f + G y.
    pub fn add(&self, unknowns: &[Unknown], y: &[f64], f: &mut [f64]) {
        for (unknown, y) in unknowns.iter().zip(y) {
            self.push(*unknown, |row, weight| f[row] += weight * y);
        }
    }

    /// What the rows of R make of numbers by rows; those of a patch at once.
    pub fn read(&self, unknowns: &[Unknown], rows: &[f64], values: &mut Vec<f64>) {
        for unknown in unknowns {
            match *unknown {
                Unknown::Patch { group, column: 0 } => {
                    let (group, mut sums) = (&self.groups[group], [0.0; MOST]);
                    for i in (group.first..group.end).filter(|&i| self.contacts[i].kind == Kind::Patch) {
                        for (weights, x) in self.patch.basis[i].iter().zip(part(rows, i)) {
                            sums.iter_mut().zip(weights).for_each(|(sum, weight)| *sum += weight * x);
                        }
                    }
                    values.extend_from_slice(&sums[..group.rank]);
                }
                Unknown::Patch { .. } => {}
                Unknown::Sticks { contact, row } => values.push(rows[3 * contact + row]),
                Unknown::Along(i) => values.push(rows[3 * i]),
                Unknown::Across(i) => {
                    let Contact { along: [a, b], slip, .. } = self.contacts[i];
                    values.push(slip * (a * rows[3 * i + 2] - b * rows[3 * i + 1]));
                }
            }
        }
    }
}
