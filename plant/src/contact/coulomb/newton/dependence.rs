//! Normal impulses over several links that A cannot tell apart: the wheels of a cart.
//!
//! Three wheels in a plane have three normal velocities, but their axles move in two ways: the velocities are dependent. Normal impulses along
//! the dependence cause no velocity except by their friction, so many distributions of the load obey Coulomb's law, with different motions.
//! As over one link ([`super::min_norm`]), the method takes the normal impulses of least norm, in N·s.

use super::super::super::tolerance::DEPENDENT;
use super::equations::{Equations, Unknown, cone_edge};

/// Part of a normal velocity in a dependence that is rounding [-].
const NO_PART: f64 = 1e-6;

/// Which of the impulses with the same effect a Newton step takes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Selection {
    /// The one that the compliance selects.
    Any,
    /// Normal impulses of least norm over each link.
    OfLinks,
    /// Normal impulses of least norm over all links.
    OfRobot,
}

/// Normal impulse of a contact that is not part of a patch.
#[derive(Clone, Copy, Debug)]
struct Normal {
    /// Index of its unknown.
    place: usize,
    contact: usize,
    /// Normal impulse per unit of the unknown.
    weight: f64,
}

/// Dependent normal velocities; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Dependence {
    normals: Vec<Normal>,
    /// Diagonal of A for the normals, less the part that the basis explains.
    remaining: Vec<f64>,
    /// Orthonormal basis N of the range of A for the normals, vector by vector.
    basis: Vec<f64>,
    /// P = 1 − N Nᵀ.
    projector: Vec<f64>,
}

impl Dependence {
    /// Finds the dependence between the normals of these unknowns.
    pub fn find(&mut self, equations: &Equations, unknowns: &[Unknown]) {
        self.normals.clear();
        self.normals.extend(unknowns.iter().enumerate().filter_map(|(place, unknown)| match *unknown {
            Unknown::ConeEdge(i) => Some(Normal { place, contact: i, weight: cone_edge(equations.cones.friction[i]) }),
            Unknown::Sticking { contact, row: 0 } => Some(Normal { place, contact, weight: 1.0 }),
            _ => None,
        }));
        self.set_basis(equations);
        let Dependence { normals, basis, projector, .. } = self;
        let n = normals.len();
        projector.clear();
        projector.resize(n * n, 0.0);
        for (p, row) in projector.chunks_exact_mut(n.max(1)).enumerate() {
            row[p] = 1.0;
            for vector in basis.chunks_exact(n) {
                row.iter_mut().zip(vector).for_each(|(entry, part)| *entry -= vector[p] * part);
            }
        }
    }

    /// Whether normals of different links depend on each other.
    pub fn joins_links(&self, equations: &Equations) -> bool {
        let link = |normal: &Normal| equations.cones.link[normal.contact];
        let mut rows = self.normals.iter().zip(self.projector.chunks_exact(self.normals.len().max(1)));
        rows.any(|(own, row)| {
            let others = self.normals.iter().zip(row).filter(|(other, _)| link(other) != link(own));
            others.into_iter().any(|(_, part)| part.abs() > NO_PART)
        })
    }

    /// Adds the conditions P S⁻² f_N = 0 to the equations, where S are the scales of the contacts.
    pub fn add_least_norm(&self, equations: &Equations, matrix: &mut [f64], unknowns: usize) {
        let scale = |normal: &Normal| equations.cones.scale[normal.contact];
        let unit = self.normals.iter().map(scale).fold(f64::INFINITY, f64::min); // for rows of about 1
        for (own, row) in self.normals.iter().zip(self.projector.chunks_exact(self.normals.len().max(1))) {
            for (other, part) in self.normals.iter().zip(row) {
                let weight = other.weight * (unit / scale(other)).powi(2);
                matrix[other.place * unknowns + own.place] += part * weight;
            }
        }
    }

    /// The pivoted Cholesky factor of A for the normals, orthonormalised by Gram-Schmidt, twice.
    fn set_basis(&mut self, equations: &Equations) {
        let Dependence { normals, remaining, basis, .. } = self;
        let (n, rows, delassus) = (normals.len(), 3 * equations.cones.contacts, &equations.cones.delassus);
        let entry = |i: usize, k: usize| delassus[3 * normals[i].contact * rows + 3 * normals[k].contact];
        remaining.clear();
        remaining.extend((0..n).map(|k| entry(k, k)));
        let least = DEPENDENT * remaining.iter().fold(0.0, |greatest: f64, left| greatest.max(*left));
        basis.clear();
        while let Some(pivot) = (0..n).max_by(|&i, &k| remaining[i].total_cmp(&remaining[k])) {
            if remaining[pivot] <= least || basis.len() == n * n {
                break;
            }
            let (start, scale) = (basis.len(), 1.0 / remaining[pivot].sqrt());
            for k in 0..n {
                let known: f64 = basis[..start].chunks_exact(n).map(|vector| vector[pivot] * vector[k]).sum();
                let part = (entry(pivot, k) - known) * scale;
                basis.push(part);
                remaining[k] -= part * part;
            }
            remaining[pivot] = 0.0;
        }
        for end in (0..basis.len()).step_by(n.max(1)) {
            let (before, rest) = basis.split_at_mut(end);
            let own = &mut rest[..n];
            for other in before.chunks_exact(n).chain(before.chunks_exact(n)) {
                let along: f64 = own.iter().zip(other).map(|(a, b)| a * b).sum();
                own.iter_mut().zip(other).for_each(|(entry, part)| *entry -= along * part);
            }
            let norm = own.iter().map(|entry| entry * entry).sum::<f64>().sqrt();
            own.iter_mut().for_each(|entry| *entry /= norm);
        }
    }
}
