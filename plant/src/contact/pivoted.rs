//! The factors of a square matrix, A = P⁻¹ L U: each unknown is taken from the rows below the greatest of its entries.
//!
//! All is kept by columns, in whole blocks: whatever is known is taken from all the unknown at once.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 3.4.

/// Numbers that are worked on at once.
const LANES: usize = 4;

/// L and U, in the room that they had before.
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
    x: Vec<[f64; LANES]>,
}

impl Pivoted {
    /// Of a matrix of `size` rows, column by column; false where it holds what is no number. A column of whose entries no more than
    /// `nothing` is left depends on those before it.
    pub fn factorize(&mut self, size: usize, matrix: &[f64], nothing: f64) -> bool {
        let width = size.div_ceil(LANES);
        self.width = width;
        self.order.clear();
        self.order.extend(0..size);
        self.lower.resize(size * width, [0.0; LANES]);
        for (list, length) in [(&mut self.upper, size * width), (&mut self.inverse, width), (&mut self.x, width)] {
            list.clear();
            list.resize(length, [0.0; LANES]);
        }
        for (upper, column) in self.upper.chunks_exact_mut(width.max(1)).zip(matrix.chunks_exact(size.max(1))) {
            upper.as_flattened_mut()[..size].copy_from_slice(column);
        }
        (0..size).all(|k| self.eliminate(k, nothing))
    }

    /// Whether column k depends on those before it.
    pub fn is_dependent(&self, k: usize) -> bool {
        self.inverse[k / LANES][k % LANES] == 0.0
    }

    /// What is left of the pivot of which least is left; zero if any column depends on others.
    pub fn least_pivot(&self) -> f64 {
        let size = |k: usize| if self.is_dependent(k) { 0.0 } else { 1.0 / self.inverse[k / LANES][k % LANES].abs() };
        (0..self.order.len()).map(size).fold(f64::INFINITY, f64::min)
    }

    /// Takes the k-th unknown from the rows below the greatest of its entries, which becomes row k.
    fn eliminate(&mut self, k: usize, nothing: f64) -> bool {
        let Pivoted { width, order, lower, upper, inverse, .. } = self;
        let (column, rest) = upper[k * *width..].split_at_mut(*width);
        let (block, lane) = (k / LANES, k % LANES);
        let own = column[block][lane];
        if own.is_nan() {
            return false; // where any is none, what is below it is none in the end
        }
        let mut greatest = [0.0; LANES];
        for (b, column) in column.iter().enumerate().skip(block) {
            let size = |c: usize| if b * LANES + c < k { 0.0 } else { column[c].abs() };
            greatest = std::array::from_fn(|c| if size(c) > greatest[c] { size(c) } else { greatest[c] });
        }
        let greatest = greatest.iter().fold(0.0, |most, &size| if size > most { size } else { most });
        if greatest <= nothing {
            column.as_flattened_mut()[k..].fill(0.0);
            lower[k * *width..][..*width].fill([0.0; LANES]);
            return true;
        }
        let mut best = k;
        if own.abs() < greatest {
            let size = |r: usize| column.as_flattened()[r].abs();
            best = (k + 1..order.len()).fold(k, |best, r| if size(r) > size(best) { r } else { best });
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
            assert!(used.factorize(size, matrix.as_slice(), 1e-14));
            used.solve(y.as_mut_slice());
            assert!((0..size).all(|k| used.is_dependent(k) == (depends && k == 3)), "{size} rows");
            let left = (&matrix * &y - right).amax();
            // of rows that depend on each other one is left out, and holds as well as the others imply
            let most = if depends { 1e-8 } else { 1e-12 };
            assert!(left < most && (!depends || y[3] == 0.0), "{size} rows: {left:.1e}");
        }
        assert!(!used.factorize(2, &[f64::NAN, 1.0, 1.0, 1.0], 1e-14), "no number");
    }
}
