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
use super::growing::Growing;
use super::pivoted::Pivoted;
use super::rays::ray;
use super::{active_set::RAYS, residual, scaled::Scaled};
use messages::scene::Law;

/// Refinements at most.
const REFINEMENTS: usize = 3;

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
    read_row: Vec<f64>,
    /// The block is symmetric and positive: what yields, and reads along what it pushes.
    symmetric: bool,
    square: Vec<f64>,
    factor: Growing,
    /// Of a block that is not.
    pivoted: Pivoted,
    solution: Vec<f64>,
}

impl Block {
    /// Writes impulse and velocity, scaled, of the basis. False when it holds what is no number.
    pub fn solve(&mut self, scaled: &Scaled, law: Law, basis: &[u8], f: &mut Vec<f64>, v: &mut Vec<f64>) -> bool {
        self.columns(scaled, law, basis);
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        v.clone_from(&scaled.drift);
        if self.columns.is_empty() {
            self.symmetric = true; // and nothing depends on anything
            return true;
        }
        if !self.factor(scaled) {
            return false;
        }
        let mut before = f64::INFINITY;
        for _ in 0..=REFINEMENTS {
            self.solution.clear();
            self.solution.extend(self.columns.iter().map(|c| -in_contact(&c.read, &v[c.first..])));
            match self.symmetric {
                true => self.factor.solve(&mut self.solution),
                false => self.pivoted.solve(&mut self.solution),
            }
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
        !self.symmetric && self.pivoted.is_dependent()
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
        let Block { columns, read_row, square, factor, pivoted, symmetric, .. } = self;
        square.clear();
        for row in &*columns {
            let read = scaled.read(row.first, &row.read, read_row);
            square.extend(columns.iter().map(|c| in_contact(&c.push, &read[c.first..])));
        }
        *symmetric = scaled.yields()
            && columns.iter().all(|column| column.read == column.push)
            && factor.factorize(columns.len(), square);
        *symmetric || pivoted.factorize(columns.len(), square)
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
