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
use super::growing::{Growing, LANES, take};
use super::rays::ray;
use super::{active_set::RAYS, residual, scaled::Scaled};
use messages::scene::Law;

/// Refinements at most.
const REFINEMENTS: usize = 3;
/// A pivot this small, the unit diagonal being 1, belongs to a column that depends on those before it.
const DEPENDENT: f64 = 1e-14;

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
    /// L and U off the diagonal, by columns in whole blocks, which are worked on at once.
    lower: Vec<[f64; LANES]>,
    upper: Vec<[f64; LANES]>,
    /// 1 / U_kk; zero where the unknown depends on those before it.
    inverse: Vec<[f64; LANES]>,
    /// Blocks of a column.
    width: usize,
    read_row: Vec<f64>,
    order: Vec<usize>,
    right: Vec<f64>,
    x: Vec<[f64; LANES]>,
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

    /// E A G = P^-1 L U.
    fn pivot(&mut self, scaled: &Scaled) -> bool {
        let p = self.columns.len();
        let width = p.div_ceil(LANES);
        self.width = width;
        self.lower.resize(p * width, [0.0; LANES]);
        self.upper.resize(p * width, [0.0; LANES]); // what is behind the last row counts for nothing
        self.inverse.clear();
        self.inverse.resize(width, [0.0; LANES]);
        for (r, row) in self.columns.iter().enumerate() {
            let read = scaled.read(row.first, &row.read, &mut self.read_row);
            let entries = self.upper.as_flattened_mut()[r..].iter_mut().step_by(width * LANES);
            self.columns.iter().zip(entries).for_each(|(c, entry)| *entry = in_contact(&c.push, &read[c.first..]));
        }
        self.order.clear();
        self.order.extend(0..p);
        (0..p).all(|k| self.eliminate(k))
    }

    /// Takes the k-th unknown from the rows below the greatest of its entries, which becomes row k. False if that is no number.
    fn eliminate(&mut self, k: usize) -> bool {
        let Block { width, upper, lower, inverse, order, .. } = self;
        let (column, rest) = upper[k * *width..].split_at_mut(*width);
        let size = |r: usize| column.as_flattened()[r].abs();
        let best = (k + 1..order.len()).fold(k, |best, r| if size(r) > size(best) { r } else { best });
        if size(best).is_nan() {
            return false;
        }
        let (block, lane) = (k / LANES, k % LANES);
        if size(best) <= DEPENDENT {
            column.as_flattened_mut()[k..].fill(0.0); // its unknown stays zero
            lower[k * *width..][..*width].fill([0.0; LANES]);
            self.dependent = true;
            return true;
        }
        if best != k {
            order.swap(k, best);
            lower.chunks_exact_mut(*width).take(k).for_each(|l| l.as_flattened_mut().swap(k, best));
            column.as_flattened_mut().swap(k, best);
        }
        let reciprocal = 1.0 / column.as_flattened()[k];
        inverse.as_flattened_mut()[k] = reciprocal;
        let l = &mut lower[k * *width..][block..*width];
        for (b, (l, u)) in l.iter_mut().zip(&mut column[block..]).enumerate() {
            let below = |c: usize| (block + b) * LANES + c > k;
            *l = std::array::from_fn(|c| if below(c) { u[c] * reciprocal } else { 0.0 });
            *u = std::array::from_fn(|c| if (block + b) * LANES + c < k { u[c] } else { 0.0 });
        }
        for column in rest.chunks_exact_mut(*width) {
            if best != k {
                column.as_flattened_mut().swap(k, best);
            }
            let known = column[block][lane];
            take(&mut column[block..], known, l);
        }
        true
    }

    fn substitute(&mut self) {
        if self.symmetric {
            self.solution.clone_from(&self.right);
            return self.factor.solve(&mut self.solution);
        }
        let Block { width, upper, lower, inverse, order, x, right, solution, .. } = self;
        x.clear();
        x.resize(*width, [0.0; LANES]);
        x.as_flattened_mut().iter_mut().zip(&*order).for_each(|(x, &row)| *x = right[row]);
        for (k, l) in lower.chunks_exact(*width).enumerate() {
            let known = x[k / LANES][k % LANES];
            take(&mut x[k / LANES..], known, &l[k / LANES..]);
        }
        for (k, u) in upper.chunks_exact(*width).enumerate().rev() {
            let known = x[k / LANES][k % LANES] * inverse[k / LANES][k % LANES];
            take(&mut x[..=k / LANES], known, u);
        }
        let x = x.as_flattened().iter().zip(inverse.as_flattened());
        solution.clear();
        solution.extend(x.take(order.len()).map(|(x, inverse)| x * inverse));
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
