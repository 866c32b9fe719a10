//! The contact problem along the edges of the friction cones: f = Σ y_r e_r, and w_r = e_r·v = (Q y + q)_r for each edge.
//!
//! The edges (1, ±μ d) span the cone of each contact. Q = EᵀAE has a row for each edge. Only rows of basic edges are read, so they are
//! computed on demand.

use super::super::scaled_problem::ScaledProblem;

/// Numbers per panel: those of the edges of four contacts, in four vector registers.
pub(super) const WIDTH: usize = 16;
/// One number per edge, for some edges; the last panel is padded with zeros.
pub(super) type Panel = [f64; WIDTH];

/// Q and q of a problem.
#[derive(Clone, Debug, Default)]
pub(super) struct Edges {
    count: usize,
    /// Edges per contact.
    pub each: usize,
    /// 1 / |e_r|.
    inverse_norm: Vec<Panel>,
    /// q.
    drift: Vec<Panel>,
    /// The computed rows of Q.
    matrix: Vec<Panel>,
    is_known: Vec<bool>,
    /// A e of an edge.
    response: Vec<f64>,
}

impl Edges {
    /// Number of edges.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Number of panels with one number per edge.
    pub fn width(&self) -> usize {
        self.drift.len()
    }

    /// Sets another problem, without its drift.
    pub fn set(&mut self, scaled: &ScaledProblem) {
        (self.each, self.count) = (scaled.facets(), scaled.contacts * scaled.facets());
        let width = self.count.div_ceil(WIDTH);
        for list in [&mut self.inverse_norm, &mut self.drift] {
            list.clear();
            list.resize(width, [0.0; WIDTH]);
        }
        let slopes = scaled.cone_slope.chunks_exact(scaled.stride()).flat_map(|cone_slope| &cone_slope[1..]);
        let pairs = self.inverse_norm.as_flattened_mut().chunks_exact_mut(2);
        pairs.zip(slopes).for_each(|(pair, slope)| pair.fill(1.0 / (1.0 + slope * slope).sqrt()));
        self.matrix.resize(self.count * width, [0.0; WIDTH]);
        self.is_known.clear();
        self.is_known.resize(self.count, false);
    }

    /// Sets the drift.
    pub fn set_drift(&mut self, scaled: &ScaledProblem, drift: &[f64]) {
        expand(scaled, drift, self.drift.as_flattened_mut());
    }

    /// Row r of Q.
    pub fn row(&mut self, scaled: &ScaledProblem, r: usize) -> &[Panel] {
        let range = r * self.width()..(r + 1) * self.width();
        if !self.is_known[r] {
            scaled.response(scaled.edge(r / self.each, r % self.each), &mut self.response);
            // clears the padding, which may hold numbers of another problem
            self.matrix[range.end - 1] = [0.0; WIDTH];
            expand(scaled, &self.response, self.matrix[range.clone()].as_flattened_mut());
            self.is_known[r] = true;
        }
        &self.matrix[range]
    }

    /// w for the amounts y of some edges, whose rows must be computed.
    pub fn velocity(&self, edges: &[usize], amounts: &[f64], w: &mut [Panel]) {
        w.copy_from_slice(&self.drift);
        let width = self.width();
        add_all(w, edges.iter().map(|&r| (amounts[r], &self.matrix[r * width..])));
    }

    /// f for the amounts y of some edges.
    pub fn impulse(&self, scaled: &ScaledProblem, edges: &[usize], amounts: &[f64], f: &mut Vec<f64>) {
        f.clear();
        f.resize(scaled.drift.len(), 0.0);
        for &r in edges {
            scaled.edge(r / self.each, r % self.each).iter().for_each(|(k, weight)| f[*k] += weight * amounts[r]);
        }
    }

    /// w as speeds: e_r·v / |e_r|.
    pub fn speeds(&self, w: &[Panel]) -> impl Iterator<Item = Panel> + Clone {
        w.iter().zip(&self.inverse_norm).map(|(w, inverse_norm)| std::array::from_fn(|k| w[k] * inverse_norm[k]))
    }
}

/// Transforms contact rows (normal and tangents) to values along the edges.
fn expand(scaled: &ScaledProblem, rows: &[f64], along: &mut [f64]) {
    match scaled.tangents {
        1 => expand_each::<2, 2>(scaled, rows, along),
        _ => expand_each::<3, 4>(scaled, rows, along),
    }
}

fn expand_each<const ROWS: usize, const EDGES: usize>(scaled: &ScaledProblem, rows: &[f64], along: &mut [f64]) {
    let contacts = rows.as_chunks::<ROWS>().0.iter().zip(scaled.cone_slope.as_chunks::<ROWS>().0);
    for ((rows, cone_slope), along) in contacts.zip(along.as_chunks_mut::<EDGES>().0) {
        for (k, pair) in along.as_chunks_mut::<2>().0.iter_mut().enumerate() {
            let part = cone_slope[k + 1] * rows[k + 1];
            *pair = [rows[0] - part, rows[0] + part];
        }
    }
}

/// The values of a contact's edges.
pub(super) fn of_contact(numbers: &[Panel], contact: usize, each: usize) -> &[f64] {
    &numbers.as_flattened()[contact * each..][..each]
}

/// sum + weight · vector.
#[inline(always)]
pub(super) fn add(sum: &mut [Panel], weight: f64, what: &[Panel]) {
    for (sum, what) in sum.iter_mut().zip(what) {
        *sum = std::array::from_fn(|k| what[k].mul_add(weight, sum[k]));
    }
}

/// sum + Σ weight · term.
#[inline(always)]
pub(super) fn add_all<'a>(sum: &mut [Panel], terms: impl Iterator<Item = (f64, &'a [Panel])> + Clone) {
    for (p, sum) in sum.iter_mut().enumerate() {
        let mut total = *sum; // stays in registers
        for (weight, term) in terms.clone() {
            let term = &term[p];
            total = std::array::from_fn(|k| term[k].mul_add(weight, total[k]));
        }
        *sum = total;
    }
}

/// Index of the first of some numbers that equals a given one.
#[inline(always)]
pub(super) fn index_of(what: f64, numbers: &Panel) -> Option<usize> {
    let places = numbers.iter().enumerate().fold(0_u32, |places, (k, number)| places | u32::from(*number == what) << k);
    (places != 0).then(|| places.trailing_zeros() as usize)
}

/// The least of some numbers.
#[inline(always)]
pub(super) fn least(numbers: &Panel) -> f64 {
    let less = |a: f64, b: f64| if b < a { b } else { a };
    let eight: [f64; 8] = std::array::from_fn(|k| less(numbers[k], numbers[k + 8]));
    let four: [f64; 4] = std::array::from_fn(|k| less(eight[k], eight[k + 4]));
    less(less(four[0], four[1]), less(four[2], four[3]))
}

/// a·b.
#[inline(always)]
pub(super) fn dot(a: &[Panel], b: &[Panel]) -> f64 {
    let mut sum = [0.0; WIDTH];
    for (a, b) in a.iter().zip(b) {
        sum = std::array::from_fn(|k| a[k].mul_add(b[k], sum[k]));
    }
    let sum: [f64; 8] = std::array::from_fn(|k| sum[k] + sum[k + 8]);
    let sum: [f64; 4] = std::array::from_fn(|k| sum[k] + sum[k + 4]);
    (sum[0] + sum[1]) + (sum[2] + sum[3]) // in this order a mirror image, which swaps the two edges of a tangent, gives the same bits
}
