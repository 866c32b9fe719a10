//! The impulse of a basis: the small linear system of its basic variables, factorised and refined.
//!
//! A complementary basis determines the mode of every contact: open, sticking, or sliding on a certain facet. The impulse is then
//! f = G y with one unknown per column, and E (A f + b) = 0 with one row per unknown:
//!
//! | contact | columns of G | rows of E |
//! |---|---|---|
//! | sticking | its basic directions | the same |
//! | sliding on facet j | (1, μ d_j) | normal |
//! | sliding between facets j and k | (1, μ d_j), (1, μ d_k) | normal; equal slip along both |
//! | energy program | its basic edges | the same |

use super::super::lu::Lu;
use super::super::tolerance::{DEPENDENT_PIVOT, REFINEMENT_REDUCTION, ROUNDING};
use super::energy_qp::minimises_energy;
use super::scaled_problem::{RowPair, ScaledProblem};
use super::{square_cone, status::EDGES};
use messages::scene::Law;

/// Refinements at most.
const MAX_REFINEMENTS: usize = 3;

#[derive(Clone, Copy, Debug)]
struct Column {
    impulse: RowPair,
    equation: RowPair,
}

/// The linear system; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct BasisSystem {
    columns: Vec<Column>,
    /// A times one column of G.
    response: Vec<f64>,
    /// E A G, column by column.
    square: Vec<f64>,
    factor: Lu,
    solution: Vec<f64>,
}

impl BasisSystem {
    /// Writes scaled impulse and velocity of the basis. False if they are not finite.
    pub fn solve(
        &mut self,
        scaled: &ScaledProblem,
        law: Law,
        basis: &[u8],
        f: &mut Vec<f64>,
        v: &mut Vec<f64>,
    ) -> bool {
        self.columns(scaled, law, basis);
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        v.clone_from(&scaled.drift);
        if self.columns.is_empty() {
            return true;
        }
        if !self.factorize(scaled) {
            return false;
        }
        let mut before = f64::INFINITY;
        for _ in 0..=MAX_REFINEMENTS {
            self.solution.clear();
            self.solution.extend(self.columns.iter().map(|column| -evaluate(&column.equation, v)));
            self.factor.solve(&mut self.solution);
            for (column, y) in self.columns.iter().zip(&self.solution) {
                column.impulse.iter().for_each(|(k, weight)| f[*k] += weight * y);
            }
            scaled.velocity(f, v);
            if !minimises_energy(law) {
                scaled.remove_compliance(f, v); // the refinement undoes the compliance wherever A is regular
            }
            let size = square_cone::scale(scaled, f);
            let left = self.columns.iter().map(|column| evaluate(&column.equation, v).abs()).fold(0.0, f64::max);
            // An error that no longer shrinks lies in dependent rows.
            if left <= ROUNDING * size || left > REFINEMENT_REDUCTION * before {
                break;
            }
            before = left;
        }
        true
    }

    fn columns(&mut self, scaled: &ScaledProblem, law: Law, basis: &[u8]) {
        let (d, stride) = (scaled.facets(), scaled.stride());
        self.columns.clear();
        for (i, &bits) in basis.iter().enumerate() {
            let first = i * stride;
            let mut column = |impulse, equation| self.columns.push(Column { impulse, equation });
            let unit = |k: usize| [(first + k, 1.0), (first, 0.0)];
            if minimises_energy(law) || bits & EDGES != 0 {
                (0..d).filter(|j| bits >> j & 1 == 1).for_each(|j| column(scaled.edge(i, j), scaled.edge(i, j)));
                continue;
            }
            let facet = |j: usize| bits >> (1 + j) & 1 == 1;
            // With both signs of one tangent basic, the slip is zero: the contact sticks at the friction limit.
            let slides = bits >> (d + 1) & 1 == 1 && (0..d).step_by(2).all(|j| !(facet(j) && facet(j + 1)));
            if slides && bits & 1 == 1 {
                let mut active = (0..d).filter(|&j| facet(j));
                if let Some(j) = active.next() {
                    column(scaled.edge(i, j), unit(0));
                    if let Some(k) = active.next() {
                        let slip = [(j, 1.0), (k, -1.0)].map(|(j, side)| {
                            let (row, sign) = ScaledProblem::facet(j);
                            (first + row, side * sign / scaled.ratio[first + row])
                        });
                        column(scaled.edge(i, k), slip);
                    }
                }
            } else if !slides {
                if bits & 1 == 1 {
                    column(unit(0), unit(0));
                }
                for k in (1..stride).filter(|k| facet(2 * k - 2) || facet(2 * k - 1)) {
                    column(unit(k), unit(k));
                }
            }
        }
    }

    /// Factorises E A G.
    fn factorize(&mut self, scaled: &ScaledProblem) -> bool {
        let BasisSystem { columns, response, square, factor, .. } = self;
        square.clear();
        for column in &*columns {
            scaled.response(column.impulse, response);
            square.extend(columns.iter().map(|row| evaluate(&row.equation, response)));
        }
        factor.factorize(columns.len(), square, DEPENDENT_PIVOT)
    }
}

/// Weighted sum of two rows.
fn evaluate(pair: &RowPair, rows: &[f64]) -> f64 {
    let [(k, x), (l, y)] = *pair;
    x * rows[k] + y * rows[l]
}
