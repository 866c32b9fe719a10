//! The impulse that belongs to a basis: the small nontrivial block, factorised and refined.
//!
//! A complementary basis says of every contact whether it is open, sticks, or slides on which facet. The impulse is then
//! f = G y, with one unknown per column, and E (A f + b) = 0, with one row per unknown:
//!
//! | contact | columns of G | rows of E |
//! |---|---|---|
//! | sticks | its basic directions | the same |
//! | slides on facet j | (1, mu d_j) | normal |
//! | slides between facets j and k | (1, mu d_j), (1, mu d_k) | normal; equal slip along both |
//! | energy QP | its basic rays | the same |

use super::energy_qp::minimises_energy;
use super::rays::ray;
use super::{active_set::RAYS, growing::Growing, residual, scaled::Scaled};
use messages::scene::Law;

/// Refinements at most.
const REFINEMENTS: usize = 3;
/// A pivot this small, the unit diagonal being 1, belongs to a column that depends on those before it.
const DEPENDENT: f64 = 1e-14;

/// Numbers that are worked on at once.
const LANES: usize = 4;

#[derive(Clone, Copy, Debug)]
struct Column {
    first: usize,
    push: [f64; 3],
    read: [f64; 3],
}

/// Workspace of the block.
#[derive(Clone, Debug, Default)]
pub(super) struct Block {
    columns: Vec<Column>,
    /// Rows in whole blocks, which are worked on at once.
    matrix: Vec<[f64; LANES]>,
    /// Blocks of a row.
    width: usize,
    read_row: Vec<f64>,
    order: Vec<usize>,
    right: Vec<f64>,
    solution: Vec<f64>,
    dependent: bool,
    /// The block is symmetric and positive: what yields, and reads along what it pushes.
    symmetric: bool,
    square: Vec<f64>,
    factor: Growing,
}

impl Block {
    /// Writes impulse and velocity, scaled, of the basis. False when it holds what is no number.
    pub fn solve(&mut self, scaled: &Scaled, law: Law, basis: &[u8], f: &mut Vec<f64>, v: &mut Vec<f64>) -> bool {
        self.columns(scaled, law, basis);
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        v.clone_from(&scaled.drift);
        self.dependent = false;
        if self.columns.is_empty() {
            return true;
        }
        if !self.factor(scaled) {
            return false;
        }
        let mut before = f64::INFINITY;
        for _ in 0..=REFINEMENTS {
            self.right.clear();
            self.right.extend(self.columns.iter().map(|c| -in_contact(&c.read, &v[c.first..])));
            self.substitute();
            for (c, y) in self.columns.iter().zip(&self.solution) {
                f[c.first..].iter_mut().zip(&c.push).for_each(|(f, g)| *f += g * y);
            }
            scaled.velocity(f, v);
            if !minimises_energy(law) {
                scaled.harden(f, v); // the refinement undoes the yielding wherever A allows
            }
            let size = residual::scale(scaled, f);
            let left = self.columns.iter().map(|c| in_contact(&c.read, &v[c.first..]).abs()).fold(0.0, f64::max);
            // What no longer shrinks is in rows that depend on others.
            if left <= 4.0 * f64::EPSILON * size || left > 0.1 * before {
                break;
            }
            before = left;
        }
        true
    }

    /// Whether some columns of the last basis depended on others, so that the impulse is one of many.
    pub fn is_dependent(&self) -> bool {
        self.dependent
    }

    fn columns(&mut self, scaled: &Scaled, law: Law, basis: &[u8]) {
        let (d, stride) = (scaled.facets(), scaled.stride());
        self.columns.clear();
        for (i, &bits) in basis.iter().enumerate() {
            let first = i * stride;
            let mut column = |push, read| self.columns.push(Column { first, push, read });
            if minimises_energy(law) || bits & RAYS != 0 {
                (0..d).filter(|j| bits >> j & 1 == 1).for_each(|j| column(ray(scaled, i, j), ray(scaled, i, j)));
                continue;
            }
            let facet = |j: usize| bits >> (1 + j) & 1 == 1;
            let normal = [1.0, 0.0, 0.0];
            // Both signs of one tangent leave no slip: that contact sticks at the limit of friction.
            let slides = bits >> (d + 1) & 1 == 1 && (0..d).step_by(2).all(|j| !(facet(j) && facet(j + 1)));
            if slides && bits & 1 == 1 {
                let mut active = (0..d).filter(|&j| facet(j));
                if let Some(j) = active.next() {
                    column(ray(scaled, i, j), normal);
                    if let Some(k) = active.next() {
                        let mut slip = [0.0; 3];
                        for (j, side) in [(j, 1.0), (k, -1.0)] {
                            let (row, sign) = Scaled::facet(j);
                            slip[row] = side * sign / scaled.ratio[first + row];
                        }
                        column(ray(scaled, i, k), slip);
                    }
                }
            } else if !slides {
                if bits & 1 == 1 {
                    column(normal, normal);
                }
                for k in (1..stride).filter(|k| facet(2 * k - 2) || facet(2 * k - 1)) {
                    let mut tangent = [0.0; 3];
                    tangent[k] = 1.0;
                    column(tangent, tangent);
                }
            }
        }
    }

    /// Factorises E A G: as a symmetric matrix, or with pivoting.
    fn factor(&mut self, scaled: &Scaled) -> bool {
        self.symmetric = scaled.yields() && self.columns.iter().all(|column| column.read == column.push);
        if self.symmetric {
            let Block { columns, square, read_row, factor, .. } = self;
            square.clear();
            for row in &*columns {
                let read = scaled.read(row.first, &row.read, read_row);
                square.extend(columns.iter().map(|c| in_contact(&c.push, &read[c.first..])));
            }
            self.symmetric = factor.factorize(columns.len(), square);
        }
        self.symmetric || self.pivot(scaled)
    }

    /// E A G = P^-1 L U in place.
    fn pivot(&mut self, scaled: &Scaled) -> bool {
        let p = self.columns.len();
        self.width = p.div_ceil(LANES);
        self.matrix.clear();
        self.matrix.resize(p * self.width, [0.0; LANES]);
        for (row, entries) in self.columns.iter().zip(self.matrix.chunks_exact_mut(self.width)) {
            let read = scaled.read(row.first, &row.read, &mut self.read_row);
            let columns = self.columns.iter().zip(entries.as_flattened_mut());
            columns.for_each(|(c, entry)| *entry = in_contact(&c.push, &read[c.first..]));
        }
        self.order.clear();
        self.order.extend(0..p);
        for k in 0..p {
            let size = |r: usize| self.matrix[r * self.width + k / LANES][k % LANES].abs();
            let best = (k + 1..p).fold(k, |best, r| if size(r) > size(best) { r } else { best });
            if size(best).is_nan() {
                return false;
            }
            if size(best) <= DEPENDENT {
                self.matrix[k * self.width + k / LANES][k % LANES] = f64::INFINITY; // its unknown stays zero
                self.dependent = true;
                continue;
            }
            if best != k {
                self.order.swap(k, best);
                (0..self.width).for_each(|c| self.matrix.swap(k * self.width + c, best * self.width + c));
            }
            self.eliminate(k);
        }
        true
    }

    /// Takes row k from those below, whole blocks at a time; the factors stay where they made zeros.
    fn eliminate(&mut self, k: usize) {
        let (block, lane) = (k / LANES, k % LANES);
        let (upper, lower) = self.matrix.split_at_mut((k + 1) * self.width);
        let pivot = &upper[k * self.width + block..];
        let reciprocal = 1.0 / pivot[0][lane];
        for row in lower.chunks_exact_mut(self.width) {
            let row = &mut row[block..];
            let (kept, factor) = (row[0], row[0][lane] * reciprocal);
            for (entries, u) in row.iter_mut().zip(pivot) {
                *entries = std::array::from_fn(|c| entries[c] - factor * u[c]);
            }
            row[0][..lane].copy_from_slice(&kept[..lane]);
            row[0][lane] = factor;
        }
    }

    fn substitute(&mut self) {
        if self.symmetric {
            self.solution.clone_from(&self.right);
            return self.factor.solve(&mut self.solution);
        }
        let p = self.columns.len();
        let row = |k: usize| &self.matrix[k * self.width..][..self.width].as_flattened()[..p];
        self.solution.clear();
        for k in 0..p {
            let known: f64 = row(k).iter().zip(&self.solution).map(|(l, y)| l * y).sum();
            self.solution.push(self.right[self.order[k]] - known);
        }
        for k in (0..p).rev() {
            let row = row(k);
            let known: f64 = row[k + 1..].iter().zip(&self.solution[k + 1..]).map(|(u, y)| u * y).sum();
            self.solution[k] = (self.solution[k] - known) / row[k];
        }
    }
}

/// Product over the rows of one contact, the first of `rows`; a row that a contact has not is zero in e.
pub(super) fn in_contact(e: &[f64; 3], rows: &[f64]) -> f64 {
    match rows {
        [a, b, c, ..] => e[0] * a + e[1] * b + e[2] * c,
        [a, b] => e[0] * a + e[1] * b,
        _ => 0.0,
    }
}
