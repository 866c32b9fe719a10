//! LU factorisation with row pivoting, A = P L U, in column-oriented form.
//!
//! All columns are stored in whole vector registers. Rows are not exchanged in memory: a mask marks the rows that remain. Each eliminated
//! unknown is subtracted from all remaining columns at once.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 3.4.

/// Numbers per vector operation.
const LANES: usize = 4;
type Lanes = [f64; LANES];

/// Factors L and U; keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct Lu {
    /// Vectors per column.
    width: usize,
    /// Pivot row and 1 / U_kk of each unknown. Zero where the unknown depends on those before it; the unknown is then zero.
    unknowns: Vec<(usize, f64)>,
    /// Mask: one for each row that remains, zero for the others.
    left: Vec<Lanes>,
    /// L and U without their diagonals, column by column.
    lower: Vec<Lanes>,
    upper: Vec<Lanes>,
    x: Vec<Lanes>,
}

impl Lu {
    /// Factorises a matrix of `size` rows, given column by column. False if it contains NaN. A column depends on those before it if its
    /// remaining entries are no greater than `min_pivot`.
    pub fn factorize(&mut self, size: usize, matrix: &[f64], min_pivot: f64) -> bool {
        let width = size.div_ceil(LANES);
        self.width = width;
        self.unknowns.clear();
        self.lower.resize(size * width, [0.0; LANES]);
        for (list, length) in [(&mut self.upper, size * width), (&mut self.left, width), (&mut self.x, width)] {
            list.clear();
            list.resize(length, [0.0; LANES]);
        }
        self.left.as_flattened_mut()[..size].fill(1.0);
        for (upper, column) in self.upper.chunks_exact_mut(width.max(1)).zip(matrix.chunks_exact(size.max(1))) {
            upper.as_flattened_mut()[..size].copy_from_slice(column);
        }
        // with a width known at compile time, the inner loops disappear
        match width {
            1 => (0..size).all(|k| self.eliminate(1, size, k, min_pivot)),
            2 => (0..size).all(|k| self.eliminate(2, size, k, min_pivot)),
            3 => (0..size).all(|k| self.eliminate(3, size, k, min_pivot)),
            4 => (0..size).all(|k| self.eliminate(4, size, k, min_pivot)),
            5 => (0..size).all(|k| self.eliminate(5, size, k, min_pivot)),
            6 => (0..size).all(|k| self.eliminate(6, size, k, min_pivot)),
            _ => (0..size).all(|k| self.eliminate(width, size, k, min_pivot)),
        }
    }

    /// Whether column k depends on those before it.
    pub fn is_dependent(&self, k: usize) -> bool {
        self.unknowns[k].1 == 0.0
    }

    /// Eliminates the k-th unknown with the greatest remaining entry of its column as pivot.
    #[inline(always)]
    fn eliminate(&mut self, width: usize, size: usize, k: usize, min_pivot: f64) -> bool {
        let Lu { unknowns, left, lower, upper, .. } = self;
        let (column, rest) = upper[k * width..].split_at_mut(width);
        let (left, l) = (&mut left[..width], &mut lower[k * width..][..width]);
        // `l` holds the remaining column first; L is written last
        for ((l, u), left) in l.iter_mut().zip(&*column).zip(&*left) {
            *l = std::array::from_fn(|c| u[c] * left[c]); // a product instead of a branch
        }
        let greatest = l.iter().fold([0.0; LANES], |greatest: Lanes, l| {
            std::array::from_fn(|c| if l[c].abs() > greatest[c] { l[c].abs() } else { greatest[c] })
        });
        let greatest = greatest.iter().fold(0.0, |most, &size| if size > most { size } else { most });
        let Some(pivot) = l.as_flattened().iter().position(|l| l.abs() == greatest).filter(|_| greatest > min_pivot)
        else {
            let numbers = l.as_flattened().iter().all(|l| !l.is_nan());
            l.fill([0.0; LANES]);
            unknowns.push((0, 0.0));
            return numbers;
        };
        let (b, lane) = (pivot / LANES, pivot % LANES);
        let reciprocal = 1.0 / l[b][lane];
        unknowns.push((pivot, reciprocal));
        for (u, l) in column.iter_mut().zip(&*l) {
            *u = std::array::from_fn(|c| u[c] - l[c]);
        }
        (left[b][lane], l[b][lane]) = (0.0, 0.0);
        l.as_flattened_mut().iter_mut().for_each(|l| *l *= reciprocal);
        for c in 0..size - k - 1 {
            // `chunks` with a width unknown at compile time would divide, which takes as long as a short column
            let column = &mut rest[c * width..][..width];
            let known = column[b][lane];
            take(column, known, l);
        }
        true
    }

    /// y = A⁻¹ y.
    pub fn solve(&mut self, y: &mut [f64]) {
        let Lu { width, unknowns, lower, upper, x, .. } = self;
        x.as_flattened_mut()[..y.len()].copy_from_slice(y);
        for (&(row, _), l) in unknowns.iter().zip(lower.chunks_exact(*width)) {
            let known = x[row / LANES][row % LANES];
            take(x, known, l);
        }
        for ((&(row, inverse), u), y) in unknowns.iter().zip(upper.chunks_exact(*width)).zip(y).rev() {
            *y = x[row / LANES][row % LANES] * inverse;
            take(x, *y, u);
        }
    }
}

/// x − known l.
#[inline(always)]
fn take(x: &mut [Lanes], known: f64, l: &[Lanes]) {
    for (x, l) in x.iter_mut().zip(l) {
        *x = std::array::from_fn(|r| l[r].mul_add(-known, x[r]));
    }
}

#[cfg(test)]
mod tests {
    use super::Lu;
    use fastrand::Rng;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn a_used_workspace_solves_random_matrices() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = Rng::with_seed(seed);
        let mut used = Lu::default();
        for size in [11, 4, 9, 1, 12, 7] {
            let mut matrix = DMatrix::from_fn(size, size, |_, _| rng.f64() - 0.5);
            matrix.fill_diagonal(0.0); // a solver without pivoting fails
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
            // one of the dependent rows is omitted; the others imply it
            let most = if depends { 1e-8 } else { 1e-12 };
            assert!(left < most && (!depends || y[3] == 0.0), "{size} rows: {left:.1e}");
        }
        assert!(!used.factorize(2, &[f64::NAN, 1.0, 1.0, 1.0], 1e-14), "no number");
    }
}
