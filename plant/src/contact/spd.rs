//! Symmetric positive definite systems: A = UᵀD⁻¹U by rows, each taken from all that follow it.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 4.2: stable without pivoting.

use super::scaled::dot;

/// A factorised matrix, in the room that it had before.
#[derive(Clone, Debug, Default)]
pub(crate) struct Spd {
    size: usize,
    /// U, row by row; below its diagonal nothing is read.
    rows: Vec<f64>,
    /// 1 / U_kk.
    inverse: Vec<f64>,
}

impl Spd {
    /// Factorises a symmetric matrix of `size` rows plus `give` on its diagonal, of which the upper half is read; false if it is
    /// not positive definite.
    pub fn factorize(&mut self, size: usize, matrix: &[f64], give: f64) -> bool {
        self.size = size;
        self.rows.clear();
        self.rows.extend_from_slice(matrix);
        self.inverse.clear();
        for k in 0..size {
            let (upper, lower) = self.rows.split_at_mut((k + 1) * size);
            let row = &mut upper[k * size..];
            row[k] += give;
            if !(row[k] > 0.0 && row[k].is_finite()) {
                return false;
            }
            let inverse = 1.0 / row[k];
            self.inverse.push(inverse);
            for (i, entries) in (k + 1..size).zip(lower.chunks_exact_mut(size)) {
                let factor = row[i] * inverse;
                entries[i..].iter_mut().zip(&row[i..]).for_each(|(a, u)| *a -= factor * u);
            }
        }
        true
    }

    /// x = A⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        let rows = self.rows.chunks_exact(self.size.max(1)).zip(&self.inverse).enumerate();
        for (k, (row, inverse)) in rows.clone() {
            let (known, rest) = x.split_at_mut(k + 1);
            let factor = known[k] * inverse;
            rest.iter_mut().zip(&row[k + 1..]).for_each(|(x, u)| *x -= factor * u);
        }
        for (k, (row, inverse)) in rows.rev() {
            x[k] = (x[k] - dot(&row[k + 1..], &x[k + 1..])) * inverse;
        }
    }
}
