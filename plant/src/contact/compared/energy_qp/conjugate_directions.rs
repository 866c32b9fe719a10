//! Q-conjugate directions of the basic edges: d_i·Q d_j is one for i = j, and else zero.
//!
//! The step to the optimum over the basic edges is then a sum, −Σ (d·w) d, for velocities w = Q y + q. Each direction is stored with its
//! velocity Q d, so one operation moves amounts and velocities together, \[y; w\].
//!
//! An entering edge adds its part that is conjugate to the present directions (Gram-Schmidt). For a leaving edge, a reflection
//! (Householder) makes all directions but the last free of that edge, and the last is dropped. The directions are the columns of R⁻¹, where
//! EᵀAE = RᵀR. The conjugate part of an edge may be as small as the compliance. Its square root then still has half of its digits, where a
//! tableau or an inverse would have none.
//!
//! # Source
//! Golub & Van Loan, *Matrix Computations*, 5.1, 5.2 and 6.5; Lawson & Hanson, *Solving Least Squares Problems*, ch. 23, 24.

use super::super::super::tolerance::DEPENDENT_PIVOT;
use super::edges::{Panel, WIDTH, add, add_all, dot};

/// One direction per basic edge; keeps its buffers.
#[derive(Clone, Debug, Default)]
pub(super) struct ConjugateDirections {
    /// Number of panels of d, and of Q d.
    width: usize,
    count: usize,
    /// \[d; Q d\] of each direction, one after the other.
    panels: Vec<Panel>,
    /// Coefficient of each direction in the present operation.
    parts: Vec<f64>,
    normal: Vec<Panel>,
    /// Change of \[y; w\] per unit amount of the edge that left last, with the other basic edges at zero velocity.
    removal: Vec<Panel>,
}

impl ConjugateDirections {
    /// Removes all directions; sets the number of panels.
    pub fn clear(&mut self, width: usize) {
        (self.width, self.count) = (width, 0);
        for list in [&mut self.normal, &mut self.removal] {
            list.clear();
            list.resize(2 * width, [0.0; WIDTH]);
        }
    }

    /// All directions: (d, Q d).
    pub fn iter(&self) -> impl Iterator<Item = (&[Panel], &[Panel])> {
        self.panels.chunks_exact(2 * self.width.max(1)).take(self.count).map(|both| both.split_at(self.width))
    }

    /// sum + Σ part · \[d; Q d\].
    pub fn add(&self, parts: &[f64], sum: &mut [Panel]) {
        add_all(sum, parts.iter().copied().zip(self.panels.chunks_exact(2 * self.width)));
    }

    /// Adds the direction of edge r, given its row of Q. False, without change, if the edge depends on the present ones.
    pub fn append(&mut self, r: usize, row: &[Panel]) -> bool {
        let (length, place) = (2 * self.width, self.count * 2 * self.width);
        if self.panels.len() < place + length {
            self.panels.resize(place + length, [0.0; WIDTH]);
        }
        let (known, new) = self.panels.split_at_mut(place);
        let new = &mut new[..length];
        let (at, own) = (self.width + r / WIDTH, row[r / WIDTH][r % WIDTH]);
        new[..self.width].fill([0.0; WIDTH]);
        new[r / WIDTH][r % WIDTH] = 1.0;
        new[self.width..].copy_from_slice(row);
        add_all(new, known.chunks_exact(length).map(|direction| (-direction[at][r % WIDTH], direction)));
        let remaining = new[at][r % WIDTH];
        let independent = remaining > DEPENDENT_PIVOT * own;
        if independent {
            let scale = 1.0 / remaining.sqrt();
            new.as_flattened_mut().iter_mut().for_each(|x| *x *= scale);
            self.count += 1;
        }
        independent
    }

    /// Removes edge r from the directions; see [`ConjugateDirections::project_out`] for vectors outside.
    pub fn remove(&mut self, r: usize) {
        let (length, at, lane) = (2 * self.width, r / WIDTH, r % WIDTH);
        let ConjugateDirections { count, panels, parts, normal, removal, .. } = self;
        let directions = &mut panels[..*count * length];
        parts.clear();
        parts.extend(directions.chunks_exact(length).map(|direction| direction[at][lane]));
        let first = parts.iter().position(|part| *part != 0.0).unwrap_or(0);
        let (parts, involved) = (&parts[first..], &mut directions[first * length..]);
        let (square, own) = (parts.iter().map(|part| part * part).sum::<f64>(), parts[parts.len() - 1]);
        normal.fill([0.0; WIDTH]);
        add_all(normal, parts.iter().copied().zip(involved.chunks_exact(length)));
        let scale = 1.0 / square;
        removal.iter_mut().zip(&*normal).for_each(|(removal, normal)| *removal = normal.map(|x| scale * x));
        // the Householder reflection between the edge's coefficients and the last direction
        let size = square.sqrt().copysign(own);
        let (others, last) = involved.split_at_mut((parts.len() - 1) * length);
        add(normal, size, last);
        let share = -1.0 / (square + size * own);
        for (part, direction) in parts.iter().zip(others.chunks_exact_mut(length)) {
            add(direction, share * part, normal);
            direction[at][lane] = 0.0;
        }
        *count -= 1;
    }

    /// Removes edge r, which has left, from a vector \[y; w\]. The velocities of the remaining basic edges do not change.
    pub fn project_out(&self, r: usize, direction: &mut [Panel]) {
        add(direction, -direction[r / WIDTH][r % WIDTH], &self.removal);
        direction[r / WIDTH][r % WIDTH] = 0.0;
    }

    /// \[d; Q d\] of the edge that was added last.
    pub fn last(&self) -> &[Panel] {
        &self.panels[(self.count - 1) * 2 * self.width..][..2 * self.width]
    }

    /// The step from a state \[y; w\] to the optimum.
    pub fn find_optimum(&mut self, state: &[Panel], direction: &mut [Panel]) {
        let ConjugateDirections { width, count, panels, parts, .. } = self;
        let directions = panels.chunks_exact(2 * (*width).max(1)).take(*count);
        parts.clear();
        parts.extend(directions.clone().map(|direction| -dot(&direction[..*width], &state[*width..])));
        direction.fill([0.0; WIDTH]);
        add_all(direction, parts.iter().copied().zip(directions));
    }

    /// The same step if the state was the optimum before the last edge was added.
    pub fn find_optimum_along_last(&self, state: &[Panel], direction: &mut [Panel]) {
        let last = self.last();
        let part = -dot(&last[..self.width], &state[self.width..]);
        direction.iter_mut().zip(last).for_each(|(direction, last)| *direction = last.map(|x| part * x));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fastrand::Rng;
    use nalgebra::{DMatrix, DVector};

    const N: usize = 12;

    /// A positive definite matrix, its rows in panels.
    fn matrix(rng: &mut Rng) -> (DMatrix<f64>, Vec<[Panel; 1]>) {
        let root = DMatrix::from_fn(N, N, |_, _| rng.f64() - 0.5);
        let matrix = &root * root.transpose() + DMatrix::identity(N, N) * 0.01;
        let row = |r: usize| [std::array::from_fn(|k| if k < N { matrix[(r, k)] } else { 0.0 })];
        let rows = (0..N).map(row).collect();
        (matrix, rows)
    }

    #[test]
    fn edges_that_enter_and_leave_in_any_order_give_the_direct_optimum() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut rng = Rng::with_seed(seed);
        let (matrix, rows) = matrix(&mut rng);
        let mut directions = ConjugateDirections::default();
        directions.clear(1);
        let (mut members, mut outside): (Vec<usize>, Vec<usize>) = (vec![], (0..N).collect());
        for _ in 0..300 {
            rng.shuffle(&mut outside);
            rng.shuffle(&mut members);
            let mut state = [[0.0; WIDTH]; 2];
            state[1][..N].fill_with(|| rng.f64() - 0.5); // q; its entries outside the basis must not count
            let mut direction = [[0.0; WIDTH]; 2];
            directions.find_optimum(&state, &mut direction);
            if let Some(new) = outside.pop_if(|_| rng.f64() < 0.6 || members.is_empty()) {
                assert!(directions.append(new, &rows[new]));
                members.push(new);
                assert!(members.len() == N || !directions.append(new, &rows[new]), "a member joined again");
                directions.find_optimum(&state, &mut direction);
            } else if let Some(old) = members.pop() {
                directions.remove(old);
                directions.project_out(old, &mut direction); // leaves the step to the optimum of the remaining edges
                outside.push(old);
            }
            let block = matrix.select_rows(&members).select_columns(&members);
            let right = -DVector::from_fn(members.len(), |k, _| state[1][members[k]]);
            let exact = block.cholesky().expect("definite").solve(&right);
            let mut expected = [0.0; WIDTH];
            members.iter().zip(&exact).for_each(|(k, y)| expected[*k] = *y);
            let moved: Panel = std::array::from_fn(|k| (0..N).map(|j| rows[k % N][0][j] * expected[j]).sum());
            for k in 0..N {
                let error = (direction[0][k] - expected[k]).abs().max((direction[1][k] - moved[k]).abs());
                assert!(error < 1e-10 * (1.0 + exact.amax()), "{error:.1e} at {k} with {} members", members.len());
            }
        }
    }

    #[test]
    fn an_independent_part_as_small_as_the_compliance_is_resolved() {
        let yields = 2e-11;
        let row = |own: usize| [std::array::from_fn(|k| if k == own { 1.0 + yields } else { f64::from(k < 3) })];
        let mut directions = ConjugateDirections::default();
        directions.clear(1);
        assert!((0..3).all(|r| directions.append(r, &row(r))), "three that are one but for that");
        let mut state = [[0.0; WIDTH]; 2];
        state[1][..3].fill(-1.0);
        let mut direction = state;
        directions.find_optimum(&state, &mut direction);
        for y in &direction[0][..3] {
            assert!((y - 1.0 / 3.0).abs() < 1e-4, "each takes a third: {y}");
        }
        for gone in [1, 0] {
            directions.remove(gone);
            directions.project_out(gone, &mut direction);
        }
        assert!(
            (direction[0][2] - 1.0).abs() < 1e-4 && direction[0][..2] == [0.0; 2],
            "the last takes all: {:?}",
            direction[0]
        );
    }
}
