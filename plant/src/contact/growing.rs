//! The factor of a symmetric positive definite matrix over a set whose members come and go: A = L Lᵀ, a row of L for each member,
//! in the order in which they came.
//!
//! A row depends on those before it alone. So whoever comes last costs one row, and who goes costs those behind it; every row is
//! as exact as if the factor had been made at once.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 4.2 and 6.5; Lawson & Hanson, *Solving Least Squares Problems*, ch. 24.

use super::scaled::dot;

/// What is left of a diagonal entry beside itself, if a row depends on those before it.
const DEPENDENT: f64 = 1e-14;

/// L, in the room that it had before.
#[derive(Clone, Debug, Default)]
pub(super) struct Growing {
    /// Room of a row.
    width: usize,
    rows: Vec<f64>,
    /// 1 / L_kk.
    inverse: Vec<f64>,
}

impl Growing {
    /// Every row of a symmetric matrix of `size` rows joins; false if it is not positive definite.
    pub fn factorize(&mut self, size: usize, matrix: &[f64]) -> bool {
        self.clear(size);
        matrix.chunks_exact(size.max(1)).enumerate().all(|(k, row)| self.join(row[..=k].iter().copied()))
    }

    /// No member; there will be `width` at most.
    pub fn clear(&mut self, width: usize) {
        self.width = width;
        self.rows.clear();
        self.rows.resize(width * width, 0.0);
        self.inverse.clear();
    }

    /// Another member: its entries with those that are there, in their order, then its own. False, and none, if it depends on them.
    pub fn join(&mut self, entries: impl Iterator<Item = f64>) -> bool {
        let count = self.inverse.len();
        let (before, row) = self.rows.split_at_mut(count * self.width);
        row.iter_mut().zip(entries).for_each(|(room, entry)| *room = entry);
        let own = row[count];
        for (k, (l, inverse)) in before.chunks_exact(self.width.max(1)).zip(&self.inverse).enumerate() {
            row[k] = (row[k] - dot(&l[..k], &row[..k])) * inverse;
        }
        let left = own - dot(&row[..count], &row[..count]);
        let independent = left > DEPENDENT * own;
        if independent {
            row[count] = left.sqrt();
            self.inverse.push(1.0 / row[count]);
        }
        independent
    }

    /// Those behind the first `count` go.
    pub fn truncate(&mut self, count: usize) {
        self.inverse.truncate(count);
    }

    /// x = A⁻¹ x.
    pub fn solve(&self, x: &mut [f64]) {
        let rows = || self.rows.chunks_exact(self.width.max(1)).zip(&self.inverse).enumerate();
        for (k, (l, inverse)) in rows() {
            x[k] = (x[k] - dot(&l[..k], &x[..k])) * inverse;
        }
        for (k, (l, inverse)) in rows().rev() {
            let (rest, last) = x.split_at_mut(k);
            last[0] *= inverse;
            rest.iter_mut().zip(l).for_each(|(x, l)| *x -= l * last[0]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Growing;
    use fastrand::Rng;
    use nalgebra::{DMatrix, DVector};

    #[test]
    fn who_joins_and_leaves_in_any_order_is_solved_for_as_all_at_once() {
        const N: usize = 12;
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = Rng::with_seed(seed);
        let root = DMatrix::from_fn(N, N, |_, _| rng.f64() - 0.5);
        let matrix = &root * root.transpose() + DMatrix::identity(N, N);
        let mut growing = Growing::default();
        growing.clear(N);
        let (mut members, mut outside): (Vec<usize>, Vec<usize>) = (vec![], (0..N).collect());
        for _ in 0..200 {
            rng.shuffle(&mut outside);
            if let Some(new) = outside.pop() {
                assert!(growing.join(members.iter().chain([&new]).map(|&k| matrix[(new, k)])));
                members.push(new);
                let twin = members.iter().chain([&new]).map(|&k| matrix[(new, k)]);
                assert!(members.len() == N || !growing.join(twin), "a member joined again");
            }
            let right = DVector::from_fn(members.len(), |_, _| rng.f64() - 0.5);
            let mut x = right.clone();
            growing.solve(x.as_mut_slice());
            let block = matrix.select_rows(&members).select_columns(&members);
            let error = (block * &x - right).amax() / x.amax();
            assert!(error < 1e-13, "{error:.1e} with {} members", members.len());
            if rng.bool() {
                let stay = rng.usize(..=members.len());
                growing.truncate(stay);
                outside.extend(members.drain(stay..));
            }
        }
    }
}
