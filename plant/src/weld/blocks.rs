//! Λ of the feet in blocks of three: force on force, force on moment, and so on; its factor, and solutions.
//!
//! By blocks, for what a processor waits for here is one division after the other: this way there is one for three rows.

use super::foot::Foot;
use super::{FEET, Pair, Six};
use nalgebra::{Matrix3, Vector3};

/// A determinant this small beside the product of the diagonal has lost its digits.
const CANCELS: f64 = 1e-8;
/// Blocks of a row.
const PARTS: usize = 2 * FEET;

/// A symmetric matrix, of which the lower blocks count.
#[derive(Clone, Debug, Default)]
pub(super) struct Blocks([[Matrix3<f64>; PARTS]; PARTS]);

/// Its factors LDLᵀ: L below the diagonal, D⁻¹ on it.
#[derive(Clone, Debug, Default)]
pub(super) struct Factored([[Matrix3<f64>; PARTS]; PARTS]);

impl Blocks {
    /// Sets the six rows and columns where foot i meets foot j <= i: the product of what their rows of Y share.
    pub fn put(&mut self, i: usize, j: usize, a: &[Six], b: &[Six]) {
        let mut product = [Six::default(); 6];
        for (a, b) in a.iter().zip(b) {
            for (sum, a) in product.iter_mut().zip(a) {
                *sum = std::array::from_fn(|k| a.mul_add(b[k], sum[k]));
            }
        }
        for (r, c) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
            self.0[2 * i + r][2 * j + c] = Matrix3::from_fn(|row, column| product[3 * r + row][3 * c + column]);
        }
    }

    /// Block of a row and a column.
    fn block(&self, row: usize, column: usize) -> Matrix3<f64> {
        if row >= column { self.0[row][column] } else { self.0[column][row].transpose() }
    }

    /// The factor, with every contact yielding by this part of what the first foot does; none unless positive definite.
    pub fn factorize(&self, feet: &[Foot], give: f64, factored: &mut Factored) -> Option<()> {
        let give = give * self.0[0][0].trace() / 3.0;
        for (i, yielding) in feet.iter().flat_map(|foot| foot.sole.yields()).enumerate() {
            let (above, rest) = factored.0.split_at_mut(i);
            let row = &mut rest[0];
            for j in 0..i {
                let known = row[..j].iter().zip(&above[j]);
                row[j] = known.fold(self.0[i][j], |entry, (ld, l)| entry - ld * l.transpose()); // L D
            }
            let mut diagonal = self.0[i][i] + yielding * give;
            for (j, entry) in row[..i].iter_mut().enumerate() {
                let ld = *entry;
                *entry *= above[j][j];
                diagonal -= *entry * ld.transpose();
            }
            row[i] = inverse(&diagonal)?;
        }
        Some(())
    }

    /// How easily a contact of foot i at d moves up, and along in its worst direction: from the three by three of A = JΛJᵀ.
    pub fn ease(&self, i: usize, d: &Vector3<f64>) -> [f64; 2] {
        let [force, mixed, moment] = [(0, 0), (1, 0), (1, 1)].map(|(r, c)| self.0[2 * i + r][2 * i + c]);
        let cross = d.cross_matrix();
        let turned = cross * mixed;
        let a = force - turned - turned.transpose() - cross * moment * cross;
        let (mean, half) = (0.5 * (a[(0, 0)] + a[(1, 1)]), 0.5 * (a[(0, 0)] - a[(1, 1)]));
        [a[(2, 2)], mean - half.hypot(a[(0, 1)])]
    }

    /// Velocity t of foot i.
    pub fn times(&self, i: usize, feet: &[Foot]) -> Pair {
        let [mut straight, mut round] = feet[i].free;
        for (j, foot) in feet.iter().enumerate() {
            let [force, moment] = foot.wrench;
            let block = |r: usize, c: usize| self.block(2 * i + r, 2 * j + c);
            straight += block(0, 0) * force + block(0, 1) * moment;
            round += block(1, 0) * force + block(1, 1) * moment;
        }
        [straight, round]
    }
}

impl Factored {
    /// x = A⁻¹ x.
    pub fn solve(&self, feet: usize, x: &mut [Pair; FEET]) {
        let x = &mut x.as_flattened_mut()[..2 * feet];
        for i in 0..x.len() {
            x[i] = self.0[i][..i].iter().zip(&*x).fold(x[i], |x, (l, known)| x - l * known);
        }
        for i in (0..x.len()).rev() {
            let rows = self.0[i + 1..].iter().zip(&x[i + 1..]);
            x[i] = rows.fold(self.0[i][i] * x[i], |x, (row, known)| x - row[i].tr_mul(known));
        }
    }
}

/// Inverse of a symmetric matrix, none unless it is positive definite: by its cofactors, with one division, unless they cancel.
fn inverse(a: &Matrix3<f64>) -> Option<Matrix3<f64>> {
    let [x, y, z] = [0, 1, 2].map(|k| a.column(k).into_owned());
    let (p, q, r) = (y.cross(&z), z.cross(&x), x.cross(&y));
    let determinant = x.dot(&p);
    if x.x > 0.0 && r.z > 0.0 && determinant > CANCELS * (x.x * y.y * z.z).abs() {
        return Some(Matrix3::from_columns(&[p, q, r]) / determinant);
    }
    Some(a.cholesky()?.inverse())
}
