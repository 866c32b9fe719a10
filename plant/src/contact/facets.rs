//! Conditions (17)-(22) as a linear complementarity problem (Stewart & Trinkle), d facets per contact.
//!
//! With friction f_F = sum beta_j d_j along the directions d_j = -t1, +t1 (, -t2, +t2):
//!
//! ```text
//! 0 <= f_N     _|_  v_N               >= 0    (17)-(19)
//! 0 <= beta_j  _|_  d_j v_F + s       >= 0    (21), (22); s becomes the slip speed
//! 0 <= s       _|_  mu f_N - sum beta >= 0    (20)
//! ```
//!
//! Two facets are the paper's one slip direction, four resist both tangents, more come near a round cone from within. In
//! scaled rows (`Scaled`) s has the scale of the normal row, so each beta_j comes with a weight c_j: `d_j v_F + c_j s` and
//! `mu f_N - sum c_j beta_j = w_s`.
//!
//! Lemke does not start at zero but where each contact slides the way it would freely go: the facet that opposes it, say
//! j, carries `beta_j = (mu f_N - sum_k c_k beta_k - w_s)/c_j`, with `s = (w_j - d_j v_F)/c_j`. That saves two pivots a
//! contact, and only normal rows can be negative, so the artificial variable lifts all contact points by one velocity.
//! A ray would need an impulse in the cone with A f = 0 and f·b + (lift) < 0; but A f = 0 means K f = 0, and b is in the
//! range of K^T, so f·b = 0: there is none.

use super::lemke::{Care, Lemke};
use super::project::corner;
use super::scaled::Scaled;

/// Assembly of the problem and the reading of its solution.
#[derive(Clone, Debug, Default)]
pub(super) struct Facets {
    lemke: Lemke,
    /// d_j of every contact in its scaled rows, and its weight c_j.
    facet: Vec<([f64; 3], f64)>,
    /// d.
    count: usize,
    /// Facet j of each contact, along which it slides at the start.
    start: Vec<usize>,
    /// For each pair: impulse, in the rows of its contact, that one unit of the nonbasic partner gives.
    push: Vec<[f64; 3]>,
    /// For each pair: coefficients with which the basic partner reads the contact's velocity.
    read: Vec<[f64; 3]>,
    combined: Vec<f64>,
}

impl Facets {
    /// Solves and writes the basis, one bit per basic variable: 0 the normal, 1 + j facet j, d + 1 the slip speed.
    /// Adds the pivots to `count`; false when there is no solution to be found.
    pub fn pivot(&mut self, scaled: &Scaled, care: Care, basis: &mut [u8], count: &mut u32) -> bool {
        self.count = scaled.facets();
        self.facet.clear();
        for ratio in scaled.ratio.chunks_exact(scaled.stride()) {
            self.facet.extend((0..self.count).map(|j| {
                let (row, sign) = Scaled::facet(j);
                let mut unit = [0.0; 3];
                unit[row] = sign;
                (unit, ratio[row])
            }));
        }
        if !self.run(scaled, care, count) {
            return false;
        }
        let size = self.count + 2;
        for (i, bits) in basis.iter_mut().enumerate() {
            // Basic at the start are the facet of the slide and s, of the other pairs the velocities.
            let at_start = |local| local == 1 + self.start[i] || local == size - 1;
            let basic = |local: &usize| at_start(*local) != self.lemke.entered(i * size + local);
            *bits = (0..size).filter(basic).map(|local| 1 << local).sum();
        }
        true
    }

    /// Solves with `d` directions around each contact, whose rows are scaled alike, and writes the impulse to within the
    /// rounding of the pivots; what it returns and counts is likewise.
    pub fn around(&mut self, scaled: &Scaled, d: usize, care: Care, f: &mut Vec<f64>, count: &mut u32) -> bool {
        self.count = d;
        self.facet.clear();
        for _ in 0..scaled.contacts {
            self.facet.extend((0..d).map(|j| {
                let [x, y] = corner(d, j);
                ([0.0, x, y], 1.0)
            }));
        }
        if !self.run(scaled, care, count) {
            return false;
        }
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        for (pair, push) in self.push.iter().enumerate() {
            let amount = self.lemke.partner(pair) * scaled.size;
            let first = pair / (d + 2) * 3;
            f[first..].iter_mut().zip(push).for_each(|(f, push)| *f += amount * push);
        }
        true
    }

    fn run(&mut self, scaled: &Scaled, care: Care, count: &mut u32) -> bool {
        self.directions(scaled);
        self.assemble(scaled);
        self.lemke.run(care, count)
    }

    /// Chooses the facets of the start and from them what each variable pushes and reads.
    fn directions(&mut self, scaled: &Scaled) {
        let (d, stride) = (self.count, scaled.stride());
        self.start.clear();
        self.push.clear();
        self.read.clear();
        for (i, facet) in self.facet.chunks_exact(d).enumerate() {
            // The facet against which the contact freely slips fastest.
            let slip = |j: usize| {
                let (unit, weight) = &facet[j];
                -(1..stride).map(|k| unit[k] * scaled.drift[i * stride + k]).sum::<f64>() / weight
            };
            let j = (1..d).fold(0, |best, j| if slip(j) > slip(best) { j } else { best });
            let (against, weight) = facet[j];
            self.start.push(j);
            for local in 0..d + 2 {
                let mut e = [0.0; 3];
                if local == 0 {
                    e[0] = 1.0;
                } else if local == d + 1 {
                    e = against.map(|x| -x / weight);
                } else if local != 1 + j {
                    let (unit, other) = facet[local - 1];
                    e = [0, 1, 2].map(|k| unit[k] - against[k] * other / weight);
                }
                self.read.push(e);
                if local == 0 {
                    e = against.map(|x| x * scaled.friction[i] / weight);
                    e[0] = 1.0;
                }
                self.push.push(e);
            }
        }
    }

    /// Writes the dictionary: `read · (A push + b)`, and the couplings of beta_j and s inside a contact.
    fn assemble(&mut self, scaled: &Scaled) {
        let Facets { lemke, facet, count, start, push, read, combined } = self;
        let (d, stride) = (*count, scaled.stride());
        let (size, n) = (d + 2, push.len());
        lemke.reset(n);
        for (r, e) in read.iter().enumerate() {
            let first = r / size * stride;
            let e = &e[..stride];
            let entries = lemke.dictionary.row_mut(r);
            let b = e.iter().zip(&scaled.drift[first..]).map(|(e, b)| e * b).sum::<f64>();
            entries[n + 1] = b / scaled.size;
            scaled.combine(first, e, combined);
            let contacts = entries.chunks_exact_mut(size).zip(push.chunks_exact(size));
            for ((columns, push), a) in contacts.zip(combined.chunks_exact(stride)) {
                let a = [a[0], a[1], if stride == 3 { a[2] } else { 0.0 }];
                for (entry, e) in columns.iter_mut().zip(push) {
                    *entry = a[0] * e[0] + a[1] * e[1] + a[2] * e[2];
                }
            }
        }
        for (i, &j) in start.iter().enumerate() {
            let ratio = |k: usize| facet[i * d + k].1;
            let first = i * size;
            let mut couple = |row: usize, column: usize, x: f64| lemke.dictionary.row_mut(first + row)[column] += x;
            couple(0, n, 1.0);
            couple(1 + j, first, scaled.friction[i] / ratio(j));
            couple(1 + j, first + d + 1, -1.0 / ratio(j));
            couple(d + 1, first + 1 + j, 1.0 / ratio(j));
            for k in (0..d).filter(|&k| k != j) {
                couple(1 + j, first + 1 + k, -ratio(k) / ratio(j));
                couple(1 + k, first + 1 + j, ratio(k) / ratio(j));
            }
        }
    }
}
