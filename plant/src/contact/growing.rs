//! The factor of a symmetric positive definite matrix over a set whose members come and go: A = L D Lᵀ with a unit diagonal of L, a
//! row of it for each member, in the order in which they came.
//!
//! A row depends on those before it alone. So whoever comes last costs one row, and who goes costs those behind it; every row is
//! as exact as if the factor had been made at once. L is kept by columns as well: whatever is known is taken from all the unknown at
//! once, whole blocks at a time.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 4.1 and 6.5; Lawson & Hanson, *Solving Least Squares Problems*, ch. 24.

/// Numbers that are worked on at once.
pub(super) const LANES: usize = 4;
/// What is left of a diagonal entry beside itself, if a row depends on those before it.
const DEPENDENT: f64 = 1e-14;

/// Four rows by four columns, or the other way about.
type Tile = [[f64; LANES]; LANES];

/// L and D, in the room that they had before. What is behind the last member is finite, and its 1 / D zero: it counts for nothing.
#[derive(Clone, Debug, Default)]
pub(super) struct Growing {
    count: usize,
    /// Tiles of a row, and of a column.
    width: usize,
    /// L below its diagonal, by rows: a tile has rows, and tiles that follow each other are of the same rows.
    rows: Vec<Tile>,
    /// The same by columns.
    columns: Vec<Tile>,
    /// 1 / D_k, zero behind the last member.
    inverse: Vec<[f64; LANES]>,
    x: Vec<[f64; LANES]>,
}

impl Growing {
    /// Every row of a symmetric matrix of `size` rows joins; false if it is not positive definite.
    pub fn factorize(&mut self, size: usize, matrix: &[f64]) -> bool {
        self.clear(size);
        matrix.chunks_exact(size.max(1)).enumerate().all(|(k, row)| self.join(row[..=k].iter().copied()))
    }

    /// No member; there will be `most` at most.
    pub fn clear(&mut self, most: usize) {
        self.width = most.div_ceil(LANES);
        let tiles = self.width * self.width;
        if self.rows.len() < tiles {
            self.rows.resize(tiles, Tile::default());
            self.columns.resize(tiles, Tile::default());
        }
        for list in [&mut self.inverse, &mut self.x] {
            list.clear();
            list.resize(self.width, [0.0; LANES]);
        }
        self.count = 0;
    }

    /// Another member: its entries with those that are there, in their order, then its own. False, and none, if it depends on them.
    pub fn join(&mut self, entries: impl Iterator<Item = f64>) -> bool {
        let (block, lane) = (self.count / LANES, self.count % LANES);
        self.x[..=block].fill([0.0; LANES]);
        self.x.as_flattened_mut().iter_mut().zip(entries).for_each(|(room, entry)| *room = entry);
        let own = std::mem::take(&mut self.x[block][lane]);
        self.descend();
        let Growing { width, rows, columns, inverse, x, .. } = self;
        let mut known = [0.0; LANES];
        for (x, inverse) in x[..=block].iter_mut().zip(&*inverse) {
            let l: [f64; LANES] = std::array::from_fn(|c| x[c] * inverse[c]);
            known = std::array::from_fn(|c| x[c].mul_add(l[c], known[c]));
            *x = l;
        }
        let left = own - (known[0] + known[1]) - (known[2] + known[3]);
        let independent = left > DEPENDENT * own;
        if independent {
            let tiles = rows[block * *width..].iter_mut().zip(columns[block..].iter_mut().step_by(*width));
            for ((rows, columns), l) in tiles.zip(&x[..=block]) {
                rows[lane] = *l;
                columns.iter_mut().zip(l).for_each(|(column, l)| column[lane] = *l);
            }
            inverse[block][lane] = 1.0 / left;
            self.count += 1;
        }
        independent
    }

    /// Those behind the first `count` go.
    pub fn truncate(&mut self, count: usize) {
        self.inverse.as_flattened_mut()[count..self.count].fill(0.0);
        self.count = count;
    }

    /// y = A⁻¹ y.
    pub fn solve(&mut self, y: &mut [f64]) {
        self.x.fill([0.0; LANES]);
        self.x.as_flattened_mut()[..y.len()].copy_from_slice(y);
        self.descend();
        for (x, inverse) in self.x.iter_mut().zip(&self.inverse) {
            *x = std::array::from_fn(|c| x[c] * inverse[c]);
        }
        self.ascend();
        y.copy_from_slice(&self.x.as_flattened()[..y.len()]);
    }

    /// x = L⁻¹ x.
    fn descend(&mut self) {
        let used = self.count.div_ceil(LANES);
        for k in 0..used {
            let tiles = &self.columns[k * self.width..][k..used];
            let (known, unknown) = self.x[k..used].split_at_mut(1);
            for c in 0..LANES {
                (c + 1..LANES).for_each(|r| take_one(&mut known[0], r, c, &tiles[0]));
            }
            unknown.iter_mut().zip(&tiles[1..]).for_each(|(x, tile)| take_four(x, &known[0], tile));
        }
    }

    /// x = L⁻ᵀ x.
    fn ascend(&mut self) {
        for k in (0..self.count.div_ceil(LANES)).rev() {
            let tiles = &self.rows[k * self.width..][..=k];
            let (unknown, known) = self.x[..=k].split_at_mut(k);
            for c in (0..LANES).rev() {
                (0..c).for_each(|r| take_one(&mut known[0], r, c, &tiles[k]));
            }
            unknown.iter_mut().zip(tiles).for_each(|(x, tile)| take_four(x, &known[0], tile));
        }
    }
}

/// x − Σ known_c l_c.
#[inline(always)]
fn take_four(x: &mut [f64; LANES], known: &[f64; LANES], l: &Tile) {
    for c in 0..LANES {
        *x = std::array::from_fn(|r| l[c][r].mul_add(-known[c], x[r]));
    }
}

/// x_r − x_c l_cr: one by one within a tile, where each waits for the one before.
#[inline(always)]
fn take_one(x: &mut [f64; LANES], r: usize, c: usize, l: &Tile) {
    x[r] = l[c][r].mul_add(-x[c], x[r]);
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

    #[test]
    fn members_that_left_leave_no_trace() {
        const N: usize = 11;
        let mut rng = Rng::with_seed(1);
        let entries: Vec<f64> = (0..N * N).map(|_| rng.f64() - 0.5).collect();
        let row = |k: usize| {
            let entries = &entries;
            (0..=k).map(move |j| if j == k { 9.0 } else { entries[k * N + j] })
        };
        let mut used = Growing::default();
        used.clear(3 * N);
        assert!((0..N).all(|k| used.join(row(k))));
        for (left, then) in [(N - 1, 0), (6, 5), (0, 5), (4, 4)] {
            used.truncate(left);
            let mut new = Growing::default();
            new.clear(N);
            for k in 0..left + then {
                assert!(new.join(row(k)) && (k < left || used.join(row(k))));
            }
            let mut x = [0.0; N].map(|_| rng.f64());
            let mut y = x;
            used.solve(&mut x[..left + then]);
            new.solve(&mut y[..left + then]);
            assert_eq!(x.map(f64::to_bits), y.map(f64::to_bits), "{left} of them stayed and {then} joined");
        }
    }
}
