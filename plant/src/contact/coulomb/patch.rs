//! Patch: the contacts of one link that stick together.
//!
//! The contacts of a rigid link move with at most six velocities, so a patch has at most six unknowns: f = Q z. The columns of Q are an
//! orthonormal basis of the range of A for these contacts. Of all impulses with the same effect, f has the least norm. It may lie outside
//! the friction cones. The impulse is then distributed again, with weights W on the contacts,
//!
//! ```text
//!   f = W Q (QᵀW Q)⁻¹ z.
//! ```
//!
//! The weight is zero for a contact that would pull, and lower for the friction of a contact that would slip. If no weights succeed, the
//! impulse of the iterate before is changed by as little as possible. That succeeds after interior points, whose impulses are within the
//! cones even if hardly any others are. If that fails too, the patch does not stick.

use super::super::projection::norm;
use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{DEPENDENT, OVERREDUCTION, PULL_ROUNDING};
use nalgebra::{Matrix6, Vector6};

/// Degrees of freedom of a rigid link.
pub(super) const LINK_DOFS: usize = 6;
/// Trials of the weights at most.
const MAX_TRIALS: usize = 10;

/// The three rows of Q of one contact.
pub(super) type Rows = [[f64; LINK_DOFS]; 3];

/// The contacts of one link, and their patch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct LinkContacts {
    pub first: usize,
    pub end: usize,
    /// The active contacts form a patch.
    pub sticks: bool,
    /// They may form a patch.
    pub may_stick: bool,
    /// The patch cannot be distributed within its cones, or it moves.
    pub fails: bool,
    /// Columns of Q.
    pub rank: usize,
    /// Contacts in the present Q, as a bit set, and its number of rows per contact.
    pub basis_of: (u64, usize),
}

/// The first rows of each contact.
fn used(basis: &mut [Rows], rows: usize) -> impl Iterator<Item = &mut [f64; LINK_DOFS]> {
    basis.iter_mut().flat_map(move |own| &mut own[..rows])
}

/// Q by contact, and the weights of normal and friction impulses; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Patch {
    pub basis: Vec<Rows>,
    diagonal: Vec<[f64; 3]>,
    weights: Vec<[f64; 2]>,
}

impl Patch {
    /// Allocates for this many contacts and forgets all bases.
    pub fn reset(&mut self, contacts: usize) {
        self.basis.clear();
        self.basis.resize(contacts, Rows::default());
        self.diagonal.resize(contacts, [0.0; 3]);
        self.weights.resize(contacts, [0.0; 2]);
    }

    /// Computes Q from the first `rows` rows of the members of a link: one for the normals, three for all. It is the pivoted Cholesky
    /// factor of their A, orthonormalised by Gram-Schmidt, twice.
    pub fn find_basis(
        &mut self,
        cones: &RoundCones,
        group: &mut LinkContacts,
        rows: usize,
        member: impl Fn(usize) -> bool,
    ) {
        let (m, contacts) = (3 * cones.contacts, group.first..group.end);
        let members = contacts.clone().filter(|&i| member(i)).fold(0, |bits, i| bits | 1 << (i - group.first).min(63));
        if contacts.len() < 64 && group.basis_of == (members, rows) {
            return;
        }
        group.basis_of = (members, rows);
        let Patch { basis, diagonal, .. } = self;
        for i in contacts.clone() {
            basis[i] = Rows::default();
            diagonal[i] =
                [0, 1, 2].map(|k| if member(i) && k < rows { cones.delassus[(3 * i + k) * (m + 1)] } else { 0.0 });
        }
        let least =
            DEPENDENT * diagonal[contacts.clone()].as_flattened().iter().fold(0.0, |greatest: f64, d| greatest.max(*d));
        group.rank = 0;
        while group.rank < LINK_DOFS {
            let c = group.rank;
            let (mut pivot, mut greatest) = ((0, 0), least);
            for i in contacts.clone() {
                for (k, left) in diagonal[i].into_iter().enumerate() {
                    if left > greatest {
                        (pivot, greatest) = ((i, k), left);
                    }
                }
            }
            if greatest <= least {
                break;
            }
            let row = basis[pivot.0][pivot.1];
            let scale = 1.0 / greatest.sqrt();
            for i in contacts.clone().filter(|&i| member(i)) {
                for k in 0..rows {
                    let known: f64 = (0..c).map(|d| basis[i][k][d] * row[d]).sum();
                    let entry = (cones.delassus[(3 * pivot.0 + pivot.1) * m + 3 * i + k] - known) * scale;
                    basis[i][k][c] = entry;
                    diagonal[i][k] -= entry * entry;
                }
            }
            diagonal[pivot.0][pivot.1] = 0.0;
            group.rank += 1;
        }
        let own = &mut basis[contacts];
        for c in 0..group.rank {
            for d in (0..c).chain(0..c) {
                let along: f64 = used(own, rows).map(|row| row[c] * row[d]).sum();
                used(own, rows).for_each(|row| row[c] -= along * row[d]);
            }
            let norm = used(own, rows).map(|row| row[c] * row[c]).sum::<f64>().sqrt();
            used(own, rows).for_each(|row| row[c] /= norm);
        }
    }

    /// Distributes the impulse of a patch over its contacts; false if that does not succeed within the cones. `before`: another impulse.
    pub fn distribute(
        &mut self,
        cones: &RoundCones,
        group: &LinkContacts,
        member: impl Fn(usize) -> bool,
        before: &[f64],
        f: &mut [f64],
    ) -> bool {
        let members = || (group.first..group.end).filter(|&i| member(i));
        let coordinates = self.coordinates(members(), f);
        let greatest = members().map(|i| f[3 * i]).fold(0.0, f64::max);
        members().for_each(|i| self.weights[i] = [1.0; 2]);
        for trial in 0..MAX_TRIALS {
            if self.adapt_weights(cones, members(), greatest, trial == 0, f) {
                for i in members() {
                    if f[3 * i] <= 0.0 {
                        f[3 * i..3 * i + 3].fill(0.0);
                    }
                }
                return true;
            }
            if !self.apply_weights(group.rank, members, &coordinates, f) {
                break;
            }
        }
        members().for_each(|i| f[3 * i..3 * i + 3].copy_from_slice(&before[3 * i..3 * i + 3]));
        self.change_least(cones, members, &coordinates, f)
    }

    /// Adapts the weights of contacts that pull or would slip. Returns whether the impulses are within their cones. `greatest` is the greatest
    /// normal impulse. In the `first` trial, friction gets weights in proportion to the normal impulses.
    fn adapt_weights(
        &mut self,
        cones: &RoundCones,
        members: impl Iterator<Item = usize>,
        greatest: f64,
        first: bool,
        f: &[f64],
    ) -> bool {
        let weights = &mut self.weights;
        let mut within = true;
        for i in members {
            let [normal, along, across] = contact_rows(f, i);
            let (friction, bound) = (norm(along, across), cones.friction[i] * normal);
            if normal <= 0.0 {
                within &= normal >= -PULL_ROUNDING * greatest;
                weights[i] = [0.0; 2];
                continue;
            }
            if first {
                weights[i][1] = bound / greatest;
            }
            if friction > bound {
                within = false;
                if !first {
                    weights[i][1] *= (bound / friction).powi(2) / OVERREDUCTION;
                }
            }
        }
        within
    }

    /// f = W Q (QᵀW Q)⁻¹ z; false, without change, if the weights leave too few contacts for that.
    fn apply_weights<M: Iterator<Item = usize>>(
        &self,
        rank: usize,
        members: impl Fn() -> M,
        coordinates: &Vector6<f64>,
        f: &mut [f64],
    ) -> bool {
        let Patch { basis, weights, .. } = self;
        let mut square = Matrix6::zeros();
        (rank..LINK_DOFS).for_each(|c| square[(c, c)] = 1.0);
        for i in members() {
            for (k, row) in basis[i].iter().enumerate() {
                let row = Vector6::from_column_slice(row);
                square += row * row.transpose() * weights[i][k.min(1)];
            }
        }
        let Some(factor) = square.cholesky() else { return false };
        let z = factor.solve(coordinates);
        for i in members() {
            for (k, row) in basis[i].iter().enumerate() {
                f[3 * i + k] = Vector6::from_column_slice(row).dot(&z) * weights[i][k.min(1)];
            }
        }
        true
    }

    /// Changes an impulse by as little as possible, so that it has these coordinates. Returns whether it is then within the cones.
    fn change_least<M: Iterator<Item = usize>>(
        &self,
        cones: &RoundCones,
        members: impl Fn() -> M,
        coordinates: &Vector6<f64>,
        f: &mut [f64],
    ) -> bool {
        let change = coordinates - self.coordinates(members(), f);
        members().all(|i| {
            for (k, row) in self.basis[i].iter().enumerate() {
                f[3 * i + k] += Vector6::from_column_slice(row).dot(&change);
            }
            let [normal, along, across] = contact_rows(f, i);
            normal >= 0.0 && norm(along, across) <= cones.friction[i] * normal
        })
    }

    /// z = Qᵀf of some contacts.
    fn coordinates(&self, members: impl Iterator<Item = usize>, f: &[f64]) -> Vector6<f64> {
        let mut coordinates = Vector6::zeros();
        for i in members {
            for (row, f) in self.basis[i].iter().zip(contact_rows(f, i)) {
                coordinates += Vector6::from_column_slice(row) * f;
            }
        }
        coordinates
    }
}
