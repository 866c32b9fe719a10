//! H = LᵀDL without fill-in: entries between different branches of the tree stay zero.
//!
//! # Source
//! Featherstone, Rigid Body Dynamics Algorithms (2008), §6.5; here row by row, each from all rows of its branch.

use crate::error::PlantError;
use crate::model::Model;
use crate::spatial::Spatial;
use nalgebra::DMatrix;

/// A matrix over degrees of freedom whose entry (i, j), j <= i, is zero unless j is on the path to i: H, and its factor L.
///
/// Row i holds the entries of the path, base first and diagonal last. So the index of (i, j) within its row is the depth of j, the same in
/// every row of the branch of j.
#[derive(Clone, Debug, PartialEq)]
pub struct PathMatrix {
    /// Length of each row.
    length: Vec<usize>,
    /// Rows in whole blocks, so that short loops need no remainder. Numbers beyond the end of a row have no meaning.
    blocks: Vec<[f64; PANEL]>,
    /// Blocks per row.
    stride: usize,
}

/// Numbers per block: those of a leg with its base, in three vector registers.
const PANEL: usize = 12;

/// Degrees of freedom of a floating base, which are on all paths.
const FLOATING: usize = 6;

impl PathMatrix {
    /// The zero matrix of a model.
    pub fn new(model: &Model) -> Self {
        let length: Vec<usize> = (1..model.links.len()).map(|link| model.depth(link)).collect();
        let stride = length.iter().copied().max().unwrap_or(1).div_ceil(PANEL);
        PathMatrix { blocks: vec![[0.0; PANEL]; stride * length.len()], length, stride }
    }

    /// Entries of the path to degree of freedom i, the last being the diagonal.
    #[inline]
    pub fn row(&self, i: usize) -> &[f64] {
        &self.blocks[i * self.stride..].as_flattened()[..self.length[i]]
    }

    /// The same, mutable.
    #[inline]
    pub fn row_mut(&mut self, i: usize) -> &mut [f64] {
        &mut self.blocks[i * self.stride..].as_flattened_mut()[..self.length[i]]
    }

    /// The first block of row i.
    #[inline]
    fn first_block(&self, i: usize) -> &[f64; PANEL] {
        &self.blocks[i * self.stride]
    }

    /// Sets the entries (i, j) for every i of the branch of j, in order.
    #[inline]
    pub(crate) fn set_column(&mut self, model: &Model, j: usize, values: impl Iterator<Item = f64>) {
        let (place, width) = (self.length[j] - 1, self.stride * PANEL);
        let numbers = self.blocks.as_flattened_mut();
        for (i, value) in model.branch(j).zip(values) {
            numbers[i * width + place] = value;
        }
    }

    /// Sets the first six entries of row i to force and moment: those of the degrees of freedom along and about the axes of W.
    #[inline]
    pub(crate) fn set_first(&mut self, i: usize, wrench: &Spatial) {
        let row = &mut self.blocks[i * self.stride];
        let Spatial { linear: f, angular: n } = wrench;
        row[..6].copy_from_slice(&[f.x, f.y, f.z, n.x, n.y, n.z]);
    }

    #[inline]
    pub(crate) fn add_diagonal(&mut self, i: usize, value: f64) {
        let place = self.length[i] - 1;
        self.blocks.as_flattened_mut()[i * self.stride * PANEL + place] += value;
    }

    /// aᵀHb.
    pub(crate) fn product(&self, model: &Model, a: &[f64], b: &[f64]) -> f64 {
        let row = |i: usize| {
            let entries = self.row(i).iter().zip(model.path(i + 1));
            entries.map(|(h, &j)| if i == j { h * a[i] * b[i] } else { h * (a[i] * b[j] + a[j] * b[i]) }).sum::<f64>()
        };
        (0..model.dofs()).map(row).sum()
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

/// The factors of H = LᵀDL: L unit lower triangular on paths, D diagonal.
#[derive(Clone, Debug)]
pub struct Factor {
    l: PathMatrix,
    /// 1 / D_i.
    inverse: Vec<f64>,
}

impl Factor {
    /// Allocates for a model.
    pub fn new(model: &Model) -> Self {
        Factor { l: PathMatrix::new(model), inverse: vec![0.0; model.dofs()] }
    }

    /// The factors of H; allocates.
    ///
    /// # Errors
    /// As [`Factor::factorize`].
    pub fn of(model: &Model, h: &PathMatrix) -> Result<Self, PlantError> {
        let mut factor = Factor::new(model);
        factor.factorize(model, h)?;
        Ok(factor)
    }

    /// Computes L and D.
    ///
    /// # Errors
    /// [`PlantError::Singular`] if H is not positive definite.
    pub fn factorize(&mut self, model: &Model, h: &PathMatrix) -> Result<(), PlantError> {
        // one block holds a leg with its base; a width known at compile time saves a quarter of the time
        match self.l.stride {
            1 => self.factorize_by(1, model, h),
            stride => self.factorize_by(stride, model, h),
        }
    }

    #[inline(always)]
    fn factorize_by(&mut self, stride: usize, model: &Model, h: &PathMatrix) -> Result<(), PlantError> {
        // U = DL: rows are scaled at the end, so that no row waits for the scaling of the one before
        for i in (0..model.dofs()).rev() {
            let (place, end) = (self.l.length[i] - 1, model.branch(i).end);
            let (rows, branch) = self.l.blocks.split_at_mut((i + 1) * stride);
            let (row, branch) = (&mut rows[i * stride..], &branch[..(end - i - 1) * stride]);
            let inverses = &self.inverse[i + 1..end];
            // U_ij = H_ij - Σ U_ki U_kj / U_kk over the branch of i
            for (b, (entries, h)) in row.iter_mut().zip(&h.blocks[i * stride..]).enumerate().take(place / PANEL + 1) {
                let mut sum = *h;
                for (u, inverse) in branch.chunks_exact(stride).zip(inverses).rev() {
                    let factor = u.as_flattened()[place] * inverse;
                    sum = std::array::from_fn(|c| (-u[b][c]).mul_add(factor, sum[c]));
                }
                *entries = sum;
            }
            let pivot = row.as_flattened()[place];
            let inverse = 1.0 / pivot;
            // the inverse of infinity is zero
            if !(pivot > 0.0 && inverse > 0.0) {
                return Err(PlantError::Singular { dof: i, pivot });
            }
            self.inverse[i] = inverse;
        }
        for (i, row) in self.l.blocks.chunks_mut(stride).enumerate() {
            row.as_flattened_mut().iter_mut().for_each(|l| *l *= self.inverse[i]);
        }
        Ok(())
    }

    /// v = H⁻¹ v.
    pub fn solve(&self, model: &Model, v: &mut [f64]) {
        match model.has_floating_base() {
            true => self.solve_by::<FLOATING>(model, v),
            false => self.solve_by::<0>(model, v),
        }
    }

    /// The same, with the first N degrees of freedom in registers: each waits for all before it, and memory would make it wait twice as
    /// long. They must be on all paths.
    #[inline(always)]
    fn solve_by<const N: usize>(&self, model: &Model, v: &mut [f64]) {
        let mut first: [f64; N] = std::array::from_fn(|i| v[i]);
        for i in (N..model.dofs()).rev() {
            let (y, place) = (v[i], self.l.length[i] - 1);
            for (l, &j) in self.l.row(i)[N..place].iter().zip(&model.path(i + 1)[N..]) {
                v[j] = (-l).mul_add(y, v[j]);
            }
            let row = self.l.first_block(i);
            first = std::array::from_fn(|j| (-row[j]).mul_add(y, first[j]));
        }
        for i in (0..N).rev() {
            let row = self.l.first_block(i);
            for j in 0..i {
                first[j] = (-row[j]).mul_add(first[i], first[j]);
            }
        }
        self.forward_solve(model, first, |inverse| inverse, v);
    }

    /// (H⁻¹)_ii: the acceleration of degree of freedom i by a unit effort on it, all others free; allocates.
    pub fn mobility(&self, model: &Model, i: usize) -> f64 {
        let mut column = vec![0.0; model.dofs()];
        column[i] = 1.0;
        self.solve(model, &mut column);
        column[i]
    }

    /// v = L⁻¹ √D⁻¹ v: the second half after [`Factor::half_solve`].
    pub fn second_half_solve(&self, model: &Model, v: &mut [f64]) {
        match model.has_floating_base() {
            true => self.forward_solve::<FLOATING>(model, std::array::from_fn(|i| v[i]), f64::sqrt, v),
            false => self.forward_solve(model, [], f64::sqrt, v),
        }
    }

    /// v = L⁻¹ s(D⁻¹) v. The first N of v are in `first`; see [`Factor::solve_by`].
    #[inline(always)]
    fn forward_solve<const N: usize>(
        &self,
        model: &Model,
        mut first: [f64; N],
        scale: impl Fn(f64) -> f64,
        v: &mut [f64],
    ) {
        for i in 0..N {
            let row = self.l.first_block(i);
            first[i] *= scale(self.inverse[i]);
            for j in 0..i {
                first[i] = (-row[j]).mul_add(first[j], first[i]);
            }
        }
        v[..N].copy_from_slice(&first);
        for i in N..model.dofs() {
            let (mut x, place) = (v[i] * scale(self.inverse[i]), self.l.length[i] - 1);
            for (l, first) in self.l.first_block(i).iter().zip(&first) {
                x = (-l).mul_add(*first, x);
            }
            for (l, &j) in self.l.row(i)[N..place].iter().zip(&model.path(i + 1)[N..]) {
                x = (-l).mul_add(v[j], x);
            }
            v[i] = x;
        }
    }

    /// Y = √D⁻¹ L⁻ᵀK for columns of K that are zero off the path to `link`, W columns side by side. The order is: one block for each degree
    /// of freedom of the path, base first, then those of the next W columns.
    ///
    /// The result has the same pattern. So in the Delassus matrix KᵀH⁻¹K = YᵀY, the columns of two links share the first [`Model::shared`]
    /// blocks.
    pub fn half_solve<const W: usize>(&self, model: &Model, link: usize, columns: &mut [[f64; W]]) {
        let path = model.path(link);
        for column in columns.chunks_exact_mut(path.len().max(1)) {
            for (depth, &i) in path.iter().enumerate().rev() {
                let (before, rest) = column.split_at_mut(depth);
                let y = rest[0];
                for (entry, l) in before.iter_mut().zip(self.l.blocks[i * self.l.stride..].as_flattened()) {
                    *entry = std::array::from_fn(|c| (-l).mul_add(y[c], entry[c]));
                }
                let root = self.inverse[i].sqrt(); // here, for flight needs none
                rest[0] = y.map(|y| y * root);
            }
        }
    }
}
