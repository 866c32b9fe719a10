//! H = LᵀL without fill-in: degrees of freedom on different branches never meet.
//!
//! # Source
//! Featherstone, Rigid Body Dynamics Algorithms (2008), §6.5.

use crate::error::PlantError;
use crate::model::Model;
use nalgebra::DMatrix;

/// A matrix over degrees of freedom whose entry (i, j), j <= i, is zero unless j is on the path to i: H, and its L.
///
/// Row i holds the entries of the path, base first, its diagonal last; so an entry's place in the row is its depth.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMatrix {
    start: Vec<usize>,
    values: Vec<f64>,
}

impl PathMatrix {
    /// Zeros for a model.
    pub fn new(model: &Model) -> Self {
        let mut start = vec![0];
        for link in 1..model.links.len() {
            start.push(start[link - 1] + model.depth(link));
        }
        PathMatrix { values: vec![0.0; start[model.dofs()]], start }
    }

    /// Entries of the path to degree of freedom i, the last being the diagonal.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.values[self.start[i]..self.start[i + 1]]
    }

    /// The same, to change.
    #[inline]
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.values[self.start[i]..self.start[i + 1]]
    }

    /// The full symmetric matrix; allocates.
    pub fn dense(&self, model: &Model) -> DMatrix<f64> {
        let mut full = DMatrix::zeros(model.dofs(), model.dofs());
        for i in 0..model.dofs() {
            for (&value, &j) in self.row(i).iter().zip(model.path(i + 1)) {
                full[(i, j)] = value;
                full[(j, i)] = value;
            }
        }
        full
    }
}

/// The factor L of H = LᵀL, lower triangular on paths.
#[derive(Clone, Debug)]
pub struct Factor {
    l: PathMatrix,
    /// 1 / L_ii.
    reciprocal: Vec<f64>,
}

impl Factor {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        Factor { l: PathMatrix::new(model), reciprocal: vec![0.0; model.dofs()] }
    }

    /// Computes L.
    ///
    /// # Errors
    /// [`PlantError::Singular`] if H is not positive definite.
    pub fn factorize(&mut self, model: &Model, h: &PathMatrix) -> Result<(), PlantError> {
        self.l.values.copy_from_slice(&h.values);
        for k in (0..model.dofs()).rev() {
            let path = model.path(k + 1);
            let (above, row) = self.l.values.split_at_mut(self.l.start[k]);
            let (&mut pivot, row) = match row[..path.len()].split_last_mut() {
                Some((pivot, row)) => (pivot, row),
                None => continue,
            };
            if !(pivot > 0.0 && pivot.is_finite()) {
                return Err(PlantError::Singular { dof: k, pivot });
            }
            // H_ij -= H_ki H_kj / H_kk for i, j on the path to k
            let inverse = 1.0 / pivot;
            for (depth, &i) in path[..row.len()].iter().enumerate() {
                let factor = row[depth] * inverse;
                let start = self.l.start[i];
                for (entry, &l) in above[start..start + depth + 1].iter_mut().zip(row.iter()) {
                    *entry -= factor * l;
                }
            }
            let scale = inverse.sqrt();
            self.reciprocal[k] = scale;
            for l in row {
                *l *= scale;
            }
        }
        Ok(())
    }

    /// v = H⁻¹ v.
    pub fn solve(&self, model: &Model, v: &mut [f64]) {
        for i in (0..model.dofs()).rev() {
            let (path, row) = (model.path(i + 1), self.l.row(i));
            v[i] *= self.reciprocal[i];
            for (l, &j) in row[..row.len() - 1].iter().zip(path) {
                v[j] -= l * v[i];
            }
        }
        for i in 0..model.dofs() {
            let (path, row) = (model.path(i + 1), self.l.row(i));
            let known: f64 = row[..row.len() - 1].iter().zip(path).map(|(l, &j)| l * v[j]).sum();
            v[i] = (v[i] - known) * self.reciprocal[i];
        }
    }

    /// y = L⁻ᵀ k, for a column k that is zero off the path to `link` and holds one entry per degree of freedom of it.
    ///
    /// The result has the same pattern, so that the Delassus matrix KᵀH⁻¹K = YᵀY has the entries
    /// Σ y_a y_b over the first [`Model::shared`] places.
    pub fn half_solve(&self, model: &Model, link: usize, k: &mut [f64]) {
        for (depth, &i) in model.path(link).iter().enumerate().rev() {
            k[depth] *= self.reciprocal[i];
            let y = k[depth];
            for (entry, l) in k[..depth].iter_mut().zip(self.l.row(i)) {
                *entry -= l * y;
            }
        }
    }
}
