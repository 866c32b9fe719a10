//! Lemke's complementary pivoting with lexicographic ties.
//!
//! Given `w = q + M z` with every pair `w_i, z_i >= 0`, `w_i z_i = 0` wanted: an artificial variable t is added on the rows
//! of `cover` and made as small as the most negative q allows. From there each variable that leaves the basis is followed
//! by its partner entering, until t leaves. Ties are broken as if row i of q were larger by eps^i, so no basis comes twice
//! and redundant contacts (singular M) do not cycle. For a copositive M the path ends at a solution.
//!
//! The dictionary has 32 digits: feet that all but hold each other ask for that, and the path ends in few pivots. It may also begin at a
//! guess, whose contradictions t makes good.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, sections 4.4 and 4.9.

use super::super::tolerance::{MAX_PIVOT_RATIO, MIN_PIVOT, PERTURBATION, TIE};
use super::dictionary::Dictionary;
use super::double_double::DoubleDouble;
use std::cmp::Ordering;

/// Pivots per pair at most, from the start and from a guess; if that is a bad one, better from the start.
const MAX_PIVOTS: [usize; 2] = [50, 2];
/// Its multiples have fractions far from each other.
const GOLDEN_RATIO: f64 = 0.618_033_988_75;

/// Workspace of one run. Variable i < n is the basic variable of row i at the start, n + i its partner, 2n is t.
#[derive(Clone, Debug, Default)]
pub(super) struct Lemke {
    /// n rows; columns: the n partners, t, constants.
    pub dictionary: Dictionary,
    original: Dictionary,
    basic: Vec<usize>,
    nonbasic: Vec<usize>,
    /// Row of a basic variable, or n + column of a nonbasic one.
    place: Vec<usize>,
    ties: Vec<usize>,
    entering: Vec<usize>,
    leaving: Vec<usize>,
}

impl Lemke {
    /// Empties the dictionary for n pairs.
    pub fn reset(&mut self, n: usize) {
        self.dictionary.reset(n, n + 2);
    }

    /// Whether the start's nonbasic partner of row i is basic now.
    pub fn entered(&self, i: usize) -> bool {
        let n = self.dictionary.rows;
        self.place[n + i] < n
    }

    /// Value of that partner in the solution.
    pub fn partner(&self, i: usize) -> DoubleDouble {
        let n = self.dictionary.rows;
        let place = self.place[n + i];
        if place < n { self.dictionary.constant(place) } else { DoubleDouble::default() }
    }

    /// Runs to a complementary basis and adds the pivots to `count`; false on a ray or after too many.
    pub fn run(&mut self, count: &mut u32) -> bool {
        self.perturb();
        self.original.copy(&self.dictionary);
        self.reset_basis();
        self.pivot_to_end(MAX_PIVOTS[0], count)
    }

    /// The same from the basis that the partners of these rows have entered; false also if it is singular.
    ///
    /// There t lifts each negative row, by a little more than it needs, so that no two reach zero together. In the rows of
    /// the start, of which the dictionary is made afresh, that is B c: c what t adds to the basic variables, B their columns.
    pub fn run_from(&mut self, entered: impl Fn(usize) -> bool, count: &mut u32) -> bool {
        let n = self.dictionary.rows;
        (0..n).for_each(|r| self.dictionary.row_mut(r)[n] = DoubleDouble::default());
        self.perturb();
        self.original.copy(&self.dictionary);
        self.reset_basis();
        self.entering.extend((0..n).filter(|&i| entered(i)));
        self.leaving.clone_from(&self.entering);
        *count += 1;
        if !self.exchange_all() {
            return false;
        }
        for r in 0..n {
            let rise = greater(-self.dictionary.constant(r), DoubleDouble::default());
            self.dictionary.row_mut(r)[n] = rise * DoubleDouble::from(1.0 + r as f64 / n as f64);
        }
        for r in 0..n {
            let rise = |place: usize| if place < n { self.dictionary.at(place, n) } else { DoubleDouble::default() };
            let columns = (0..n).filter(|i| self.place[n + i] < n);
            let lifts = columns.map(|i| self.original.at(r, i) * rise(self.place[n + i]));
            self.original.row_mut(r)[n] = rise(self.place[r]) - lifts.fold(DoubleDouble::default(), |sum, x| sum + x);
        }
        self.pivot_to_end(MAX_PIVOTS[1], count)
    }

    /// Adds to each row of q what no residual shows, so that no two are tied: a tie that rounding decides wrongly among
    /// feet that hold each other ends on a ray.
    fn perturb(&mut self) {
        let n = self.dictionary.rows;
        for r in 0..n {
            let perturbation = PERTURBATION * (1.0 + (r as f64 * GOLDEN_RATIO).fract());
            let q = &mut self.dictionary.row_mut(r)[n + 1];
            *q = *q + perturbation.into();
        }
    }

    /// The basis of the start.
    fn reset_basis(&mut self) {
        let n = self.dictionary.rows;
        // room for the worst at once: nothing is taken from the heap on the way
        for list in [&mut self.ties, &mut self.entering, &mut self.leaving] {
            list.clear();
            list.reserve(n + 1);
        }
        self.basic.clear();
        self.basic.extend(0..n);
        self.nonbasic.clear();
        self.nonbasic.extend(n..=2 * n);
        self.place.clear();
        self.place.extend((0..n).chain(n..=2 * n));
    }

    /// Lets t enter, then partners until it leaves.
    fn pivot_to_end(&mut self, most: usize, count: &mut u32) -> bool {
        let n = self.dictionary.rows;
        let Some(mut row) = self.first_leaving_row() else { return true };
        let mut column = n;
        for _ in 0..most * n {
            *count += 1;
            let left = self.basic[row];
            let pivot = f64::from(self.dictionary.at(row, column)).abs();
            self.exchange(row, column);
            if left == 2 * n {
                return true;
            }
            if !(1.0 / MAX_PIVOT_RATIO..MAX_PIVOT_RATIO).contains(&pivot) && !self.refactorize() {
                return false;
            }
            column = self.place[(left + n) % (2 * n)] - n;
            let Some(next) = self.ratio_test(column) else { return false };
            row = next;
        }
        false
    }

    /// Makes the dictionary of the present basis from the original one.
    fn refactorize(&mut self) -> bool {
        let n = self.dictionary.rows;
        self.dictionary.copy(&self.original);
        self.entering.clear();
        self.entering.extend(self.basic.iter().filter(|&&variable| variable >= n).map(|variable| variable - n));
        self.leaving.clear();
        self.leaving.extend((0..n).filter(|&variable| self.place[variable] >= n));
        self.basic.clear();
        self.basic.extend(0..n);
        self.nonbasic.clear();
        self.nonbasic.extend(n..=2 * n);
        self.exchange_all()
    }

    /// Exchanges the rows of `leaving` for the columns of `entering`, the largest pivots first; false if one is nothing.
    fn exchange_all(&mut self) -> bool {
        let n = self.dictionary.rows;
        while !self.entering.is_empty() {
            let (mut best, mut size) = ((0, 0), MIN_PIVOT);
            for (i, &row) in self.leaving.iter().enumerate() {
                for (j, &column) in self.entering.iter().enumerate() {
                    let entry = f64::from(self.dictionary.at(row, column)).abs();
                    if entry > size {
                        (best, size) = ((i, j), entry);
                    }
                }
            }
            if size <= MIN_PIVOT {
                return false;
            }
            let (row, column) = (self.leaving.swap_remove(best.0), self.entering.swap_remove(best.1));
            self.dictionary.exchange(row, column);
            std::mem::swap(&mut self.basic[row], &mut self.nonbasic[column]);
        }
        for (row, &variable) in self.basic.iter().enumerate() {
            self.place[variable] = row;
        }
        for (column, &variable) in self.nonbasic.iter().enumerate() {
            self.place[variable] = n + column;
        }
        true
    }

    /// Row that t must lift most; of equal ones the last, whose perturbation is smallest.
    fn first_leaving_row(&self) -> Option<usize> {
        let (n, zero) = (self.dictionary.rows, DoubleDouble::default());
        let rise = |r: usize| -self.dictionary.constant(r) / self.dictionary.at(r, n);
        let lifted = (0..n).filter(|&r| self.dictionary.at(r, n) > zero && rise(r) > zero);
        lifted.max_by(|&a, &b| order(rise(a), rise(b)))
    }

    fn exchange(&mut self, row: usize, column: usize) {
        let n = self.dictionary.rows;
        self.dictionary.exchange(row, column);
        std::mem::swap(&mut self.basic[row], &mut self.nonbasic[column]);
        self.place[self.basic[row]] = row;
        self.place[self.nonbasic[column]] = n + column;
    }

    /// Lexicographic ratio test: the row that reaches zero first while the variable of `column` grows.
    fn ratio_test(&mut self, column: usize) -> Option<usize> {
        let n = self.dictionary.rows;
        let Lemke { dictionary, place, ties, .. } = self;
        let slope = |r: usize| -dictionary.at(r, column);
        let ratio = |r: usize| greater(dictionary.constant(r), DoubleDouble::default()) / slope(r);
        let tie = |r: usize| DoubleDouble::from(TIE * dictionary.largest(r));
        let falling = (0..n).filter(|&r| slope(r) > DoubleDouble::from(MIN_PIVOT));
        let least = falling.clone().map(ratio).min_by(|&a, &b| order(a, b))?;
        ties.clear();
        ties.extend(falling.filter(|&r| dictionary.constant(r) - least * slope(r) <= tie(r)));
        if let Some(&end) = ties.iter().find(|&&r| place[2 * n] == r) {
            return Some(end);
        }
        for &at in &place[..n] {
            if ties.len() < 2 {
                break;
            }
            // Coefficient of this power of eps in row r: the perturbed variable itself, or minus its column.
            let power = |r: usize| if at >= n { -dictionary.at(r, at - n) } else { f64::from(at == r).into() };
            let least = ties.iter().map(|&r| power(r) / slope(r)).min_by(|&a, &b| order(a, b))?;
            ties.retain(|&r| power(r) - least * slope(r) <= tie(r));
        }
        ties.iter().copied().max_by(|&a, &b| order(slope(a), slope(b)))
    }
}

/// What is no number is equal to all.
fn order(a: DoubleDouble, b: DoubleDouble) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}

fn greater(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    if a > b { a } else { b }
}
