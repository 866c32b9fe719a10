//! Lemke's complementary pivoting with lexicographic ties.
//!
//! Given `w = q + M z` with every pair `w_i, z_i >= 0`, `w_i z_i = 0` wanted: an artificial variable t is added on the rows
//! of `cover` and made as small as the most negative q allows. From there each variable that leaves the basis is followed
//! by its partner entering, until t leaves. Ties are broken as if row i of q were larger by eps^i, so no basis comes twice
//! and redundant contacts (singular M) do not cycle. For a copositive M the path ends at a solution.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, sections 4.4 and 4.9.

use super::dictionary::Dictionary;

/// What counts as rounding on the way.
#[derive(Clone, Copy, Debug)]
pub(super) struct Care {
    /// Entries below this are no pivots: in the scaled problem an honest one is about 1.
    pub zero: f64,
    /// Rows that come this close to zero together are ties; q is at most about 1.
    pub tie: f64,
    /// Whether the dictionary is made afresh after each pivot.
    pub afresh: bool,
    /// Pivots per pair at most.
    pub most: usize,
}

/// Rounding is about 1e-15 but grows from pivot to pivot: wide enough that in redundant rows it does not choose. What
/// that costs is made good when the impulse is computed afresh from the final basis.
pub(super) const QUICK: Care = Care { zero: 1e-9, tie: 1e-9, afresh: false, most: 50 };
/// The same for a path that is short or given up.
pub(super) const SHORT: Care = Care { most: 2, ..QUICK };
/// Ties as narrow as 1e-10 needs in a step of many contacts, and a path that is given up if it is long.
pub(super) const FINE: Care = Care { zero: 1e-12, tie: 1e-12, afresh: false, most: 1 };
/// Sees directions in which the feet hold each other by 1e-12 of what they weigh, at a hundred times the cost.
pub(super) const CAREFUL: Care = Care { zero: 1e-13, tie: 1e-14, afresh: true, most: 50 };

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
    pub fn partner(&self, i: usize) -> f64 {
        let n = self.dictionary.rows;
        let place = self.place[n + i];
        if place < n { self.dictionary.constant(place) } else { 0.0 }
    }

    /// Runs to a complementary basis and adds the pivots to `count`; false on a ray or after too many.
    pub fn run(&mut self, care: Care, count: &mut u32) -> bool {
        let n = self.dictionary.rows;
        if care.afresh {
            self.original.copy(&self.dictionary);
        }
        // room for the worst at once: nothing is taken from the heap on the way
        for list in [&mut self.ties, &mut self.entering, &mut self.leaving] {
            list.clear();
            list.reserve(n);
        }
        self.basic.clear();
        self.basic.extend(0..n);
        self.nonbasic.clear();
        self.nonbasic.extend(n..=2 * n);
        self.place.clear();
        self.place.extend((0..n).chain(n..=2 * n));
        let Some(mut row) = self.first_row() else { return true };
        let mut column = n;
        for _ in 0..care.most * n {
            *count += 1;
            let left = self.basic[row];
            self.exchange(row, column);
            if left == 2 * n {
                return true;
            }
            column = self.place[(left + n) % (2 * n)] - n;
            if care.afresh {
                self.refresh();
                column = self.place[(left + n) % (2 * n)] - n;
            }
            let Some(next) = self.leaving(column, care) else { return false };
            row = next;
        }
        false
    }

    /// Makes the dictionary of the present basis from the original one, the largest pivots first.
    fn refresh(&mut self) {
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
        while !self.entering.is_empty() {
            let (mut best, mut size) = ((0, 0), -1.0);
            for (i, &row) in self.leaving.iter().enumerate() {
                for (j, &column) in self.entering.iter().enumerate() {
                    if self.dictionary.at(row, column).abs() > size {
                        (best, size) = ((i, j), self.dictionary.at(row, column).abs());
                    }
                }
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
    }

    /// Row that t must lift most; of equal ones the last, whose perturbation is smallest.
    fn first_row(&self) -> Option<usize> {
        let n = self.dictionary.rows;
        let lift = |r: usize| -self.dictionary.constant(r) / self.dictionary.at(r, n);
        let lifted = (0..n).filter(|&r| self.dictionary.at(r, n) > 0.0 && lift(r) > 0.0);
        lifted.max_by(|&a, &b| lift(a).total_cmp(&lift(b)))
    }

    fn exchange(&mut self, row: usize, column: usize) {
        let n = self.dictionary.rows;
        self.dictionary.exchange(row, column);
        std::mem::swap(&mut self.basic[row], &mut self.nonbasic[column]);
        self.place[self.basic[row]] = row;
        self.place[self.nonbasic[column]] = n + column;
    }

    /// Lexicographic ratio test: the row that reaches zero first while the variable of `column` grows.
    fn leaving(&mut self, column: usize, care: Care) -> Option<usize> {
        let n = self.dictionary.rows;
        let Lemke { dictionary, place, ties, .. } = self;
        let slope = |r: usize| -dictionary.at(r, column);
        let ratio = |r: usize| dictionary.constant(r).max(0.0) / slope(r);
        let least = (0..n).filter(|&r| slope(r) > care.zero).map(ratio).fold(f64::INFINITY, f64::min);
        ties.clear();
        ties.extend((0..n).filter(|&r| slope(r) > care.zero && dictionary.constant(r) - least * slope(r) <= care.tie));
        if let Some(&end) = ties.iter().find(|&&r| place[2 * n] == r) {
            return Some(end);
        }
        for &at in &place[..n] {
            if ties.len() < 2 {
                break;
            }
            // Coefficient of this power of eps in row r: the perturbed variable itself, or minus its column.
            let power = |r: usize| if at >= n { -dictionary.at(r, at - n) } else { f64::from(at == r) };
            let least = ties.iter().map(|&r| power(r) / slope(r)).fold(f64::INFINITY, f64::min);
            ties.retain(|&r| power(r) - least * slope(r) <= care.tie);
        }
        ties.iter().copied().max_by(|&a, &b| slope(a).total_cmp(&slope(b)))
    }
}
