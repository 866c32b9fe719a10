//! Lemke's complementary pivoting with the lexicographic ratio test.
//!
//! It solves `w = q + M z` with `w_i, z_i >= 0` and `w_i z_i = 0` for every pair. An artificial variable t is added to the rows and takes
//! the least value at which no row is negative. Whenever a variable leaves the basis, its partner enters, until t leaves. Ties are broken
//! as if row i of q were larger by eps^i. Hence no basis occurs twice, and redundant contacts (singular M) cause no cycle. For a copositive
//! M the path ends at a solution.
//!
//! The dictionary has 32 digits. Two feet that almost lock each other need them, and with them the path ends in few pivots. The path may
//! also start from a guessed basis; t then compensates its negative rows.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, sections 4.4 and 4.9.

use super::super::tolerance::{MAX_PIVOT_RATIO, MIN_PIVOT, PERTURBATION, TIE};
use super::dictionary::Dictionary;
use super::double_double::DoubleDouble;
use std::cmp::Ordering;

/// Pivots per pair at most: from the initial basis, and from a guess. A bad guess costs more than the initial basis.
const MAX_PIVOTS: [usize; 2] = [50, 2];
/// (√5 − 1)/2: the fractional parts of its multiples are evenly spread.
const GOLDEN_RATIO: f64 = 0.618_033_988_75;

/// Workspace of one run. Variable i < n is initially basic in row i, n + i is its partner, and 2n is t.
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
    /// Resets the dictionary for n pairs.
    pub fn reset(&mut self, n: usize) {
        self.dictionary.reset(n, n + 2);
    }

    /// Whether the partner of row i has become basic.
    pub fn entered(&self, i: usize) -> bool {
        let n = self.dictionary.rows;
        self.place[n + i] < n
    }

    /// Value of the partner of row i at the solution.
    pub fn partner(&self, i: usize) -> DoubleDouble {
        let n = self.dictionary.rows;
        let place = self.place[n + i];
        if place < n { self.dictionary.constant(place) } else { DoubleDouble::default() }
    }

    /// Pivots to a complementary basis and adds the pivots to `count`. False on a ray or after too many pivots.
    pub fn run(&mut self, count: &mut u32) -> bool {
        self.perturb();
        self.original.copy(&self.dictionary);
        self.reset_basis();
        self.pivot_to_end(MAX_PIVOTS[0], count)
    }

    /// Starts from the basis in which the partners of the `entered` rows are basic; false also if that basis is singular.
    ///
    /// In that basis, t raises each negative row slightly above zero, so that no two rows reach zero together. In terms of the initial
    /// rows, from which the dictionary is recomputed, that is B c: c holds the coefficients of t in the basic variables, and B holds their
    /// columns.
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

    /// Adds a perturbation below any residual to each row of q, so that no rows are tied. If rounding decides a tie wrongly, as with feet
    /// that lock each other, the path ends on a ray.
    fn perturb(&mut self) {
        let n = self.dictionary.rows;
        for r in 0..n {
            let perturbation = PERTURBATION * (1.0 + (r as f64 * GOLDEN_RATIO).fract());
            let q = &mut self.dictionary.row_mut(r)[n + 1];
            *q = *q + perturbation.into();
        }
    }

    /// Resets to the initial basis.
    fn reset_basis(&mut self) {
        let n = self.dictionary.rows;
        // reserves for the worst case, so that pivoting does not allocate
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

    /// Lets t enter, then one partner after the other, until t leaves.
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

    /// Recomputes the dictionary of the present basis from the original one.
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

    /// Exchanges the rows of `leaving` for the columns of `entering`, the largest pivots first. False if a pivot is zero.
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

    /// Row with the most negative value per unit of t. Of tied rows the last, whose perturbation is smallest.
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

    /// Lexicographic ratio test: the row that first reaches zero while the variable of `column` grows.
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
            // Coefficient of this power of eps in row r: of the perturbed variable itself, or minus its column.
            let power = |r: usize| if at >= n { -dictionary.at(r, at - n) } else { f64::from(at == r).into() };
            let least = ties.iter().map(|&r| power(r) / slope(r)).min_by(|&a, &b| order(a, b))?;
            ties.retain(|&r| power(r) - least * slope(r) <= tie(r));
        }
        ties.iter().copied().max_by(|&a, &b| order(slope(a), slope(b)))
    }
}

/// Order of two numbers; NaN equals everything.
fn order(a: DoubleDouble, b: DoubleDouble) -> Ordering {
    a.partial_cmp(&b).unwrap_or(Ordering::Equal)
}

fn greater(a: DoubleDouble, b: DoubleDouble) -> DoubleDouble {
    if a > b { a } else { b }
}
