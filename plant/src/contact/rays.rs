//! The contact problem along the edges of its cones: f = Σ y_r e_r, and each ray's w_r = e_r·v = (Q y + q)_r.
//!
//! Each cone is spanned by its edge rays (1, ±mu d). Q = RᵀAR has a row for each, and only those of rays that push are ever read:
//! they are made when they are asked for.

use super::scaled::Scaled;

/// Q and q of a problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Rays {
    /// 1 / |e_r|.
    shortness: Vec<f64>,
    /// q.
    drift: Vec<f64>,
    /// Q, of the rows that are there.
    matrix: Vec<f64>,
    there: Vec<bool>,
    /// eᵀA of a ray.
    read: Vec<f64>,
}

/// Ray j of contact i in scaled rows.
pub(super) fn ray(scaled: &Scaled, i: usize, j: usize) -> [f64; 3] {
    let (k, sign) = Scaled::facet(j);
    let mut ray = [1.0, 0.0, 0.0];
    ray[k] = sign * scaled.reach[i * scaled.stride() + k];
    ray
}

impl Rays {
    /// Rays of all contacts.
    pub fn count(&self) -> usize {
        self.shortness.len()
    }

    /// Of another problem, its drift apart.
    pub fn set(&mut self, scaled: &Scaled) {
        self.shortness.clear();
        for slope in scaled.reach.chunks_exact(scaled.stride()).flat_map(|reach| &reach[1..]) {
            self.shortness.extend([1.0 / (1.0 + slope * slope).sqrt(); 2]);
        }
        self.matrix.resize(self.count() * self.count(), 0.0);
        self.there.clear();
        self.there.resize(self.count(), false);
    }

    /// Of the same problem with this drift.
    pub fn turn(&mut self, scaled: &Scaled, drift: &[f64]) {
        self.drift.resize(self.count(), 0.0);
        expand(scaled, drift, &mut self.drift);
    }

    /// q_r.
    pub fn drift(&self, r: usize) -> f64 {
        self.drift[r]
    }

    /// Row r of Q.
    pub fn row(&mut self, scaled: &Scaled, r: usize) -> &[f64] {
        let range = r * self.count()..(r + 1) * self.count();
        if !self.there[r] {
            let (i, j) = (r / scaled.facets(), r % scaled.facets());
            let read = scaled.read(i * scaled.stride(), &ray(scaled, i, j), &mut self.read);
            expand(scaled, read, &mut self.matrix[range.clone()]);
            self.there[r] = true;
        }
        &self.matrix[range]
    }

    /// w of the amounts y of some rays, whose rows are there, into `w`.
    pub fn velocity(&self, rays: &[usize], amounts: &[f64], w: &mut Vec<f64>) {
        w.clone_from(&self.drift);
        for (&r, &y) in rays.iter().zip(amounts) {
            let row = &self.matrix[r * w.len()..][..w.len()];
            w.iter_mut().zip(row).for_each(|(w, q)| *w = q.mul_add(y, *w));
        }
    }

    /// f of the amounts y of some rays.
    pub fn push(&self, scaled: &Scaled, rays: &[usize], amounts: &[f64], f: &mut Vec<f64>) {
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        for (&r, &y) in rays.iter().zip(amounts) {
            let (first, (k, sign)) = (r / scaled.facets() * scaled.stride(), Scaled::facet(r % scaled.facets()));
            f[first] += y;
            f[first + k] += y * sign * scaled.reach[first + k];
        }
    }

    /// w as speeds: e_r·v / |e_r|.
    pub fn speeds(&self, w: &[f64]) -> impl Iterator<Item = f64> {
        w.iter().zip(&self.shortness).map(|(w, shortness)| w * shortness)
    }
}

/// What rows of contacts are along the rays of each: normal and tangents, there and back.
fn expand(scaled: &Scaled, rows: &[f64], along: &mut [f64]) {
    let contacts = rows.chunks_exact(scaled.stride()).zip(scaled.reach.chunks_exact(scaled.stride()));
    for ((rows, reach), along) in contacts.zip(along.chunks_exact_mut(scaled.facets())) {
        for ((row, slope), pair) in rows[1..].iter().zip(&reach[1..]).zip(along.chunks_exact_mut(2)) {
            pair.copy_from_slice(&[rows[0] - slope * row, rows[0] + slope * row]);
        }
    }
}
