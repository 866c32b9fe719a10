//! The factors of a square matrix, A = P⁻¹ L U: each unknown is taken from the rows below the greatest of its entries.
//!
//! All is kept by columns, in whole blocks: whatever is known is taken from all the unknown at once.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 3.4.

use super::growing::LANES;

/// A pivot this small, the entries being about 1, belongs to a column that depends on those before it.
const DEPENDENT: f64 = 1e-14;

/// L and U, in the room that they had before. What is behind the last row counts for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Pivoted {
    /// Blocks of a column.
    width: usize,
    /// Row of A that row k has become.
    order: Vec<usize>,
    /// L and U off the diagonal, column by column.
    lower: Vec<[f64; LANES]>,
    upper: Vec<[f64; LANES]>,
    /// 1 / U_kk; zero where the unknown depends on those before it, and itself stays zero.
    inverse: Vec<[f64; LANES]>,
    dependent: bool,
    x: Vec<[f64; LANES]>,
}

impl Pivoted {
    /// Of a matrix of `size` rows; false where it holds what is no number.
    pub fn factorize(&mut self, size: usize, matrix: &[f64]) -> bool {
        let width = size.div_ceil(LANES);
        self.width = width;
        self.dependent = false;
        self.order.clear();
        self.order.extend(0..size);
        for list in [&mut self.lower, &mut self.upper] {
            list.resize(size * width, [0.0; LANES]);
        }
        for list in [&mut self.inverse, &mut self.x] {
            list.clear();
            list.resize(width, [0.0; LANES]);
        }
        for (r, row) in matrix.chunks_exact(size.max(1)).enumerate() {
            let places = self.upper.as_flattened_mut()[r..].iter_mut().step_by(width * LANES);
            places.zip(row).for_each(|(place, entry)| *place = *entry);
        }
        (0..size).all(|k| self.eliminate(k))
    }

    /// Whether some columns depend on others.
    pub fn is_dependent(&self) -> bool {
        self.dependent
    }

    /// Takes the k-th unknown from the rows below the greatest of its entries, which becomes row k.
    fn eliminate(&mut self, k: usize) -> bool {
        let Pivoted { width, order, lower, upper, inverse, .. } = self;
        let (column, rest) = upper[k * *width..].split_at_mut(*width);
        let size = |r: usize| column.as_flattened()[r].abs();
        let best = (k + 1..order.len()).fold(k, |best, r| if size(r) > size(best) { r } else { best });
        if size(best).is_nan() {
            return false;
        }
        let (block, lane) = (k / LANES, k % LANES);
        if size(best) <= DEPENDENT {
            column.as_flattened_mut()[k..].fill(0.0);
            lower[k * *width..][..*width].fill([0.0; LANES]);
            self.dependent = true;
            return true;
        }
        if best != k {
            order.swap(k, best);
            lower.chunks_exact_mut(*width).take(k).for_each(|l| l.as_flattened_mut().swap(k, best));
            column.as_flattened_mut().swap(k, best);
        }
        let reciprocal = 1.0 / column[block][lane];
        inverse[block][lane] = reciprocal;
        let l = &mut lower[k * *width..][block..*width];
        for (b, (l, u)) in l.iter_mut().zip(&mut column[block..]).enumerate() {
            let row = |c: usize| (block + b) * LANES + c;
            *l = std::array::from_fn(|c| if row(c) > k { u[c] * reciprocal } else { 0.0 });
            *u = std::array::from_fn(|c| if row(c) < k { u[c] } else { 0.0 });
        }
        for c in 0..order.len() - k - 1 {
            // chunks of a width that is not known divide, which takes as long as a short column
            let column = &mut rest[c * *width..][..*width];
            if best != k {
                column.as_flattened_mut().swap(k, best);
            }
            let known = column[block][lane];
            take(&mut column[block..], known, l);
        }
        true
    }

    /// y = A⁻¹ y.
    pub fn solve(&mut self, y: &mut [f64]) {
        let Pivoted { width, order, lower, upper, inverse, x, .. } = self;
        x.as_flattened_mut().iter_mut().zip(&*order).for_each(|(x, &row)| *x = y[row]);
        for (k, l) in lower.chunks_exact(*width).enumerate() {
            let known = x[k / LANES][k % LANES];
            take(&mut x[k / LANES..], known, &l[k / LANES..]);
        }
        for (k, u) in upper.chunks_exact(*width).enumerate().rev() {
            let known = x[k / LANES][k % LANES] * inverse[k / LANES][k % LANES];
            take(&mut x[..=k / LANES], known, u);
        }
        let x = x.as_flattened().iter().zip(inverse.as_flattened());
        y.iter_mut().zip(x).for_each(|(y, (x, inverse))| *y = x * inverse);
    }
}

/// x − known l.
fn take(x: &mut [[f64; LANES]], known: f64, l: &[[f64; LANES]]) {
    for (x, l) in x.iter_mut().zip(l) {
        *x = std::array::from_fn(|r| l[r].mul_add(-known, x[r]));
    }
}

#[cfg(test)]
mod tests {
    use super::Pivoted;
    use fastrand::Rng;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn what_it_solves_for_solves_the_matrix_whatever_was_there_before() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = Rng::with_seed(seed);
        let mut used = Pivoted::default();
        for size in [11, 4, 9, 1, 12, 7] {
            let mut matrix = DMatrix::from_fn(size, size, |_, _| rng.f64() - 0.5);
            matrix.fill_diagonal(0.0); // only who looks for a pivot gets on
            let depends = size > 4;
            if depends {
                let sum = matrix.column(0) - matrix.column(2);
                matrix.set_column(3, &sum);
            }
            let mut unknown = DVector::from_fn(size, |_, _| rng.f64());
            if depends {
                unknown[3] = 0.0;
            }
            if size == 1 {
                matrix[(0, 0)] = -2.0;
            }
            let right = &matrix * &unknown;
            let mut y = right.clone();
            assert!(used.factorize(size, matrix.transpose().as_slice()));
            assert_eq!(used.is_dependent(), depends, "{size} rows");
            used.solve(y.as_mut_slice());
            let left = (&matrix * &y - right).amax();
            // of rows that depend on each other one is left out, and holds as well as the others imply
            let most = if depends { 1e-8 } else { 1e-12 };
            assert!(left < most && (!depends || y[3] == 0.0), "{size} rows: {left:.1e}");
        }
        assert!(!used.factorize(2, &[f64::NAN, 1.0, 1.0, 1.0]), "no number");
    }
}
