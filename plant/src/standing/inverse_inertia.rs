//! Λ⁻¹ of the feet in 3×3 blocks (force-force, force-moment, and so on), its factorisation and solution.
//!
//! The factors are those of the scalar LDLᵀ factorisation with L unit triangular, computed by blocks. No block is inverted: inverses would
//! lose the compliance where feet press against each other.

use super::foot::Foot;
use super::spatial_pair::{MAX_FEET, PaddedRow, SpatialPair};
use crate::model::Model;
use nalgebra::{Matrix3, Vector3};

/// Blocks per row.
const BLOCK_ROWS: usize = 2 * MAX_FEET;

/// A symmetric matrix; only its lower blocks are stored.
#[derive(Clone, Debug, Default)]
pub(super) struct InverseInertia([[Matrix3<f64>; BLOCK_ROWS]; BLOCK_ROWS]);

/// LDLᵀ factorisation.
#[derive(Clone, Debug, Default)]
pub(super) struct BlockLdl {
    /// LD below the diagonal.
    scaled: [[Matrix3<f64>; BLOCK_ROWS]; BLOCK_ROWS],
    /// L below the diagonal.
    below: [[Matrix3<f64>; BLOCK_ROWS]; BLOCK_ROWS],
    /// Factorisations of the diagonal blocks.
    diagonal: [Ldl3; BLOCK_ROWS],
}

/// LDLᵀ of a 3×3 block: l_21, l_31, l_32, and D⁻¹.
#[derive(Clone, Copy, Debug, Default)]
struct Ldl3 {
    l: [f64; 3],
    inverse: Vector3<f64>,
}

impl InverseInertia {
    /// Λ⁻¹ = YᵀY of the feet.
    pub fn fill(&mut self, model: &Model, feet: &[Foot]) -> &InverseInertia {
        for (i, a) in feet.iter().enumerate() {
            for (j, b) in feet[..=i].iter().enumerate() {
                let shared = if i == j { a.rows.len() } else { model.shared(a.link, b.link) };
                self.put(i, j, &a.rows[..shared], &b.rows[..shared]);
            }
        }
        self
    }

    /// Sets the block of feet i and j <= i: the product of the rows of Y that both share.
    fn put(&mut self, i: usize, j: usize, a: &[PaddedRow], b: &[PaddedRow]) {
        let mut product = [PaddedRow::default(); 6];
        for (a, b) in a.iter().zip(b) {
            for (sum, a) in product.iter_mut().zip(a) {
                *sum = std::array::from_fn(|k| a.mul_add(b[k], sum[k]));
            }
        }
        for (r, c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            self.0[2 * i + r][2 * j + c] = Matrix3::from_fn(|row, column| product[3 * r + row][3 * c + column]);
        }
    }

    /// Product of one block and x.
    #[inline(always)]
    fn block_times(&self, row: usize, column: usize, x: &Vector3<f64>) -> Vector3<f64> {
        if row >= column { self.0[row][column] * x } else { self.0[column][row].tr_mul(x) }
    }

    /// Factorises, with each contact compliant by this part of the first foot's translational mobility. `None` unless Λ⁻¹ is positive
    /// definite.
    pub fn factorize<'a>(
        &self,
        feet: &[Foot],
        relative_compliance: f64,
        factored: &'a mut BlockLdl,
    ) -> Option<&'a BlockLdl> {
        let relative_compliance = relative_compliance * self.0[0][0].trace() / 3.0;
        for (i, compliance) in feet.iter().flat_map(|foot| foot.sole.compliance(relative_compliance)).enumerate() {
            let BlockLdl { scaled, below, diagonal } = factored;
            let mut own = self.0[i][i] + compliance;
            for j in 0..i {
                let known = scaled[i][..j].iter().zip(&below[j]);
                let ld = diagonal[j].divide(&known.fold(self.0[i][j], |entry, (ld, l)| entry - ld * l.transpose()));
                let l = Matrix3::from_fn(|row, column| ld[(row, column)] * diagonal[j].inverse[column]);
                own -= l * ld.transpose();
                (scaled[i][j], below[i][j]) = (ld, l);
            }
            diagonal[i] = Ldl3::of(&own)?;
        }
        Some(factored)
    }

    /// Velocity t of foot i under the wrenches of all feet.
    pub fn times(&self, i: usize, feet: &[Foot]) -> SpatialPair {
        let [mut linear, mut angular] = feet[i].free;
        for (j, foot) in feet.iter().enumerate() {
            let [force, moment] = &foot.wrench;
            let times = |r: usize, c: usize, x| self.block_times(2 * i + r, 2 * j + c, x);
            linear += times(0, 0, force) + times(0, 1, moment);
            angular += times(1, 0, force) + times(1, 1, moment);
        }
        [linear, angular]
    }
}

impl BlockLdl {
    /// x = A⁻¹ x.
    pub fn solve(&self, feet: usize, x: &mut [SpatialPair; MAX_FEET]) {
        let x = &mut x.as_flattened_mut()[..2 * feet];
        for i in 0..x.len() {
            let left = self.below[i][..i].iter().zip(&*x).fold(x[i], |x, (l, known)| x - l * known);
            x[i] = self.diagonal[i].forward_solve(left);
        }
        for i in (0..x.len()).rev() {
            let rows = self.below[i + 1..].iter().zip(&x[i + 1..]);
            let own = &self.diagonal[i];
            x[i] = own.backward_solve(
                rows.fold(x[i].component_mul(&own.inverse), |x, (row, known)| x - row[i].tr_mul(known)),
            );
        }
    }
}

impl Ldl3 {
    /// Factorises a symmetric matrix; `None` unless it is positive definite.
    fn of(a: &Matrix3<f64>) -> Option<Ldl3> {
        // a_11 times the second pivot, so that the two divisions can run in parallel
        let (minor, across) = (a.m11 * a.m22 - a.m21 * a.m21, a.m11 * a.m32 - a.m21 * a.m31);
        let (first, second) = (1.0 / a.m11, 1.0 / minor);
        let l = [a.m21 * first, a.m31 * first, across * second];
        let last = a.m33 - l[1] * a.m31 - l[2] * across * first;
        let definite = a.m11 > 0.0 && minor > 0.0 && last > 0.0;
        definite.then(|| Ldl3 { l, inverse: Vector3::new(first, a.m11 * second, 1.0 / last) })
    }

    /// A L⁻ᵀ.
    fn divide(&self, a: &Matrix3<f64>) -> Matrix3<f64> {
        let [p, q, r] = self.l;
        let [x, y, z] = [0, 1, 2].map(|k| a.column(k).into_owned());
        let y = y - x * p;
        Matrix3::from_columns(&[x, y, z - x * q - y * r])
    }

    /// L⁻¹ x.
    fn forward_solve(&self, x: Vector3<f64>) -> Vector3<f64> {
        let [p, q, r] = self.l;
        let y = x.y - p * x.x;
        Vector3::new(x.x, y, x.z - q * x.x - r * y)
    }

    /// L⁻ᵀ x.
    fn backward_solve(&self, x: Vector3<f64>) -> Vector3<f64> {
        let [p, q, r] = self.l;
        let (z, y) = (x.z, x.y - r * x.z);
        Vector3::new(x.x - p * y - q * z, y, z)
    }
}
