//! Conditions (17)-(22) as a linear complementarity problem with d facets per contact (Stewart & Trinkle).
//!
//! With friction f_F = Σ β_j d_j along the directions d_j = -t1, +t1 (, -t2, +t2):
//!
//! ```text
//!   0 <= f_N  ⟂  v_N          >= 0    (17)-(19)
//!   0 <= β_j  ⟂  d_j v_F + s  >= 0    (21), (22); s becomes the slip speed
//!   0 <= s    ⟂  μ f_N - Σ β  >= 0    (20)
//! ```
//!
//! Two facets are the paper's one slip direction. Four facets resist both tangents. More facets approximate a round cone from within. In
//! scaled rows (`ScaledProblem`), s has the scale of the normal row, and each β_j has a weight c_j: `d_j v_F + c_j s` and
//! `μ f_N - Σ c_j β_j = w_s`.
//!
//! Lemke's method does not start from zero. It starts with each contact sliding in the direction of its free slip. The opposing facet j
//! carries `β_j = (μ f_N - Σ_k c_k β_k - w_s)/c_j`, with `s = (w_j - d_j v_F)/c_j`. That saves two pivots per contact. Only normal rows can
//! then be negative, so the artificial variable adds one velocity to all contacts.
//!
//! The method cannot end on a ray. A ray needs an impulse in the cone with A f = 0 and a negative f·b, where the allowed approach, which is
//! not negative, is added to b. But A f = 0 means K f = 0, and b is in the range of Kᵀ, so f·b = 0.

use super::double_double::DoubleDouble;
use super::lemke::Lemke;
use super::polygon::vertex;
use super::scaled_problem::ScaledProblem;

/// Assembly of the problem and its solution by Lemke's method. Each contact has `d + 2` complementary pairs.
#[derive(Clone, Debug, Default)]
pub(super) struct Facets {
    lemke: Lemke,
    /// d_j of every contact in its scaled rows, and its weight c_j.
    facet: Vec<([DoubleDouble; 3], DoubleDouble)>,
    /// d.
    count: usize,
    /// Facet on which each contact slides initially.
    initial_facet: Vec<usize>,
    /// For each pair: the impulse of its contact for one unit of the nonbasic variable.
    impulse_column: Vec<[DoubleDouble; 3]>,
    /// For each pair: the coefficients of the contact's velocity in the basic variable.
    velocity_row: Vec<[DoubleDouble; 3]>,
}

/// Whether a pair's partner is basic initially: the facet of the slide, and the slip speed.
fn is_initially_basic(slides: usize, size: usize, local: usize) -> bool {
    local == 1 + slides || local == size - 1
}

impl Facets {
    /// Solves with two facets per tangent, from the given basis if possible, else from the initial basis. Writes basis and impulse. The
    /// bits of the basis stand for basic variables: 0 the normal, 1 + j facet j, d + 1 the slip speed. Adds the pivots to `count`. False if
    /// no solution was found.
    pub fn solve_along_tangents(
        &mut self,
        scaled: &ScaledProblem,
        basis: &mut [u8],
        f: &mut Vec<f64>,
        count: &mut u32,
    ) -> bool {
        self.set_tangent_facets(scaled);
        let size = self.count + 2;
        let Facets { lemke, initial_facet, .. } = self;
        let entered = |pair: usize| {
            let (i, local) = (pair / size, pair % size);
            (basis[i] >> local & 1 == 1) != is_initially_basic(initial_facet[i], size, local)
        };
        let mut solved = lemke.run_from(entered, count);
        if !solved {
            self.set_tangent_facets(scaled);
            solved = self.lemke.run(count);
        }
        if solved {
            self.basis(basis);
            self.impulse(scaled, f);
        }
        solved
    }

    /// Sets up the problem with two facets per tangent.
    fn set_tangent_facets(&mut self, scaled: &ScaledProblem) {
        self.count = scaled.facets();
        self.facet.clear();
        for ratio in scaled.ratio.chunks_exact(scaled.stride()) {
            self.facet.extend((0..self.count).map(|j| {
                let (row, sign) = ScaledProblem::facet(j);
                let mut unit = [DoubleDouble::default(); 3];
                unit[row] = sign.into();
                (unit, ratio[row].into())
            }));
        }
        self.set_initial_facets(scaled);
        self.assemble(scaled);
    }

    /// Solves with friction in `d` directions of equal angles around each contact, and writes the impulse. The rows of each contact must
    /// have a common scale. Count and result as above.
    pub fn solve_polygon(&mut self, scaled: &ScaledProblem, d: usize, f: &mut Vec<f64>, count: &mut u32) -> bool {
        self.count = d;
        self.facet.clear();
        for _ in 0..scaled.contacts {
            self.facet.extend((0..d).map(|j| {
                let [x, y] = vertex(d, j);
                ([0.0, x, y].map(DoubleDouble::from), 1.0.into())
            }));
        }
        self.set_initial_facets(scaled);
        self.assemble(scaled);
        let solved = self.lemke.run(count);
        if solved {
            self.impulse(scaled, f);
        }
        solved
    }

    fn basis(&self, basis: &mut [u8]) {
        let size = self.count + 2;
        for (i, bits) in basis.iter_mut().enumerate() {
            let basic = |local: &usize| {
                is_initially_basic(self.initial_facet[i], size, *local) != self.lemke.entered(i * size + local)
            };
            *bits = (0..size).filter(basic).map(|local| 1 << local).sum();
        }
    }

    fn impulse(&self, scaled: &ScaledProblem, f: &mut Vec<f64>) {
        f.clear();
        for (i, columns) in self.impulse_column.chunks_exact(self.count + 2).enumerate() {
            let first = i * (self.count + 2);
            let of = |row: usize| {
                let parts = columns.iter().enumerate().map(|(k, column)| self.lemke.partner(first + k) * column[row]);
                f64::from(parts.fold(DoubleDouble::default(), |sum, part| sum + part)) * scaled.size
            };
            f.extend((0..scaled.stride()).map(of));
        }
    }

    /// Chooses the initial facets, and from them the columns and rows of each variable.
    fn set_initial_facets(&mut self, scaled: &ScaledProblem) {
        let (d, stride, zero) = (self.count, scaled.stride(), DoubleDouble::default());
        self.initial_facet.clear();
        self.impulse_column.clear();
        self.velocity_row.clear();
        for (i, facet) in self.facet.chunks_exact(d).enumerate() {
            // Speed of the free slip against facet j.
            let slip = |j: usize| {
                let (unit, weight) = facet[j];
                -(1..stride).fold(zero, |sum, k| sum + unit[k] * scaled.drift[i * stride + k].into()) / weight
            };
            let j = (1..d).fold(0, |best, j| if slip(j) > slip(best) { j } else { best });
            let (against, weight) = facet[j];
            self.initial_facet.push(j);
            for local in 0..d + 2 {
                let mut e = [zero; 3];
                if local == 0 {
                    e[0] = 1.0.into();
                } else if local == d + 1 {
                    e = against.map(|x| -x / weight);
                } else if local != 1 + j {
                    let (unit, other) = facet[local - 1];
                    e = [0, 1, 2].map(|k| unit[k] - against[k] * other / weight);
                }
                self.velocity_row.push(e);
                if local == 0 {
                    e = against.map(|x| x * scaled.friction[i].into() / weight);
                    e[0] = 1.0.into();
                }
                self.impulse_column.push(e);
            }
        }
    }

    /// Assembles the dictionary: `velocity_row · (A impulse_column + b)`, and the coupling of beta_j and s within each contact.
    fn assemble(&mut self, scaled: &ScaledProblem) {
        let Facets { lemke, facet, count, initial_facet, impulse_column, velocity_row } = self;
        let (d, stride, m) = (*count, scaled.stride(), scaled.drift.len());
        let (size, n) = (d + 2, impulse_column.len());
        lemke.reset(n);
        for (r, e) in velocity_row.iter().enumerate() {
            let weights = || (r / size * stride..).zip(&e[..stride]).filter(|(_, e)| **e != DoubleDouble::default());
            let read = |column: usize| {
                weights().fold(DoubleDouble::default(), |sum, (k, &e)| sum + e * scaled.delassus[k * m + column].into())
            };
            let entries = lemke.dictionary.row_mut(r);
            let b = weights().fold(DoubleDouble::default(), |sum, (k, &e)| sum + e * scaled.drift[k].into());
            entries[n + 1] = b / scaled.size.into();
            for (i, (columns, impulse)) in
                entries.chunks_exact_mut(size).zip(impulse_column.chunks_exact(size)).enumerate()
            {
                let a: [DoubleDouble; 3] =
                    [0, 1, 2].map(|l| if l < stride { read(i * stride + l) } else { DoubleDouble::default() });
                for (entry, e) in columns.iter_mut().zip(impulse) {
                    *entry = a[0] * e[0] + a[1] * e[1] + a[2] * e[2];
                }
            }
        }
        for (i, &j) in initial_facet.iter().enumerate() {
            let ratio = |k: usize| facet[i * d + k].1;
            let first = i * size;
            let mut couple = |row: usize, column: usize, x: DoubleDouble| {
                let entry = &mut lemke.dictionary.row_mut(first + row)[column];
                *entry = *entry + x;
            };
            let one = DoubleDouble::from(1.0);
            couple(0, n, one);
            couple(1 + j, first, DoubleDouble::from(scaled.friction[i]) / ratio(j));
            couple(1 + j, first + d + 1, -one / ratio(j));
            couple(d + 1, first + 1 + j, one / ratio(j));
            for k in (0..d).filter(|&k| k != j) {
                couple(1 + j, first + 1 + k, -ratio(k) / ratio(j));
                couple(1 + k, first + 1 + j, ratio(k) / ratio(j));
            }
        }
    }
}
