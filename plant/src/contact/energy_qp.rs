//! The quadratic program (14)-(16) as printed, by principal pivoting.
//!
//! Each planar cone |f_F| <= mu f_N is spanned by its edge rays (1, +-mu): f = sum y_j (1, mu d_j), y >= 0. Then (14) is
//! min 1/2 y^T Q y + q^T y with Q = R^T A R positive semidefinite, and its conditions are `0 <= y _|_ Q y + q >= 0`.
//!
//! The method drives the most negative w = Q y + q to zero by growing its y; a basic y that would become negative on the
//! way leaves first. Every pivot is on the diagonal, and a w that is still negative is independent of what is basic
//! already, so redundant contacts (singular Q) meet no zero pivot.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, section 4.2; in the form of Lawson & Hanson's NNLS.

use super::{dictionary::Dictionary, scaled::Scaled};

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyQp {
    dictionary: Dictionary,
    rays: Vec<[f64; 3]>,
    basic: Vec<bool>,
}

/// Ray j of contact i in scaled rows.
pub(super) fn ray(scaled: &Scaled, i: usize, j: usize) -> [f64; 3] {
    let (k, sign) = Scaled::facet(j);
    let mut ray = [1.0, 0.0, 0.0];
    ray[k] = sign * scaled.friction[i] / scaled.ratio[i * scaled.stride() + k];
    ray
}

impl EnergyQp {
    /// Solves and writes the basis, one bit per basic ray. Returns the number of pivots, or `None` beyond 50 per ray.
    pub fn pivot(&mut self, scaled: &Scaled, zero: f64, basis: &mut [u8]) -> Option<u32> {
        self.assemble(scaled);
        let pivots = self.run(zero)?;
        for (bits, basic) in basis.iter_mut().zip(self.basic.chunks_exact(scaled.facets())) {
            *bits = (0..basic.len()).filter(|&j| basic[j]).map(|j| 1 << j).sum();
        }
        Some(pivots)
    }

    fn assemble(&mut self, scaled: &Scaled) {
        let (d, stride, m) = (scaled.facets(), scaled.stride(), scaled.drift.len());
        let n = scaled.contacts * d;
        self.rays.clear();
        self.rays.extend((0..n).map(|r| ray(scaled, r / d, r % d)));
        self.basic.clear();
        self.basic.resize(n, false);
        self.dictionary.reset(n, n + 1);
        for r in 0..n {
            let (first, read) = (r / d * stride, &self.rays[r]);
            let entries = self.dictionary.row_mut(r);
            for (k, weight) in read[..stride].iter().enumerate() {
                let row = &scaled.delassus[(first + k) * m..][..m];
                for (c, push) in self.rays.iter().enumerate() {
                    let a = &row[c / d * stride..][..stride];
                    entries[c] += weight * a.iter().zip(push).map(|(a, p)| a * p).sum::<f64>();
                }
                entries[n] += weight * scaled.drift[first + k];
            }
        }
    }

    fn run(&mut self, zero: f64) -> Option<u32> {
        let EnergyQp { dictionary, basic, .. } = self;
        let n = dictionary.rows;
        let mut pivots = 0;
        let scale = (0..n).map(|r| dictionary.constant(r).abs()).fold(0.0, f64::max);
        loop {
            let negative = (0..n).filter(|&r| !basic[r] && dictionary.constant(r) < -zero * scale);
            let Some(driven) = negative.min_by(|&a, &b| dictionary.constant(a).total_cmp(&dictionary.constant(b))) else {
                return Some(pivots);
            };
            while !basic[driven] {
                // Growth of the driven y at which each basic y, or the driven w itself, reaches zero.
                let reach = |r: usize| dictionary.constant(r) / -dictionary.at(r, driven);
                let blocks = |&r: &usize| basic[r] && dictionary.at(r, driven) < -zero;
                let goal = if dictionary.at(driven, driven) > zero { reach(driven) } else { f64::INFINITY };
                let first = (0..n).filter(blocks).min_by(|&a, &b| reach(a).total_cmp(&reach(b)));
                let row = first.filter(|&r| reach(r) < goal).unwrap_or(driven);
                if pivots >= 50 * n as u32 || (row == driven && goal == f64::INFINITY) {
                    return None;
                }
                dictionary.exchange(row, row);
                basic[row] = !basic[row];
                pivots += 1;
            }
        }
    }
}
