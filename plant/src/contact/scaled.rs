//! The contact problem in energy units: rows and columns scaled by diag(A)^-1/2, so that A has a unit diagonal and
//! impulses and velocities are both in sqrt(J).

use super::residual::greatest;
use super::tolerance::{COMPLIANCE, IMMOVABLE};
use super::{Problem, lift};
use messages::scene::Law;

/// What [`Scaled::give`] adds to the unit diagonal: contacts yield by this much.
///
/// Two flat feet on one robot hold each other along directions that H sees at 1e-12 or not at all. There the impulse is
/// the quotient of two roundings, and pivoting loses its way. With this the problem has one solution, that of least norm
/// where A is singular, and its residual in the problem without it is no more than this, relative to the impulse.
pub(crate) const YIELD: f64 = COMPLIANCE;

/// The same for pivoting in 32 digits: far above the rounding of A, so that there is one solution, and far below what
/// counts as solved.
pub(super) const HAIR: f64 = 4e-12;

/// Two rows of the problem with their weights.
pub(super) type Mix = [(usize, f64); 2];

/// `v = A f + b` scaled: f~ = sqrt(A_kk) f, v~ = v / sqrt(A_kk). A direction that cannot move has a zero row and gets no
/// impulse.
#[derive(Clone, Debug, Default)]
pub(super) struct Scaled {
    pub contacts: usize,
    pub tangents: usize,
    /// A~, m by m.
    pub delassus: Vec<f64>,
    /// b~, the allowed approach added to the normal rows.
    pub drift: Vec<f64>,
    /// sqrt(A_kk), zero where immovable.
    pub root: Vec<f64>,
    /// mu of each contact.
    pub friction: Vec<f64>,
    /// For each tangent row c = sqrt(A_NN / A_kk), so that the cone reads sum c |f~_k| <= mu f~_N.
    pub ratio: Vec<f64>,
    /// mu / c, likewise: how far friction along one tangent goes.
    pub reach: Vec<f64>,
    /// Largest scaled drift.
    pub size: f64,
    /// 1 / root, zero where immovable.
    pub inverse: Vec<f64>,
    /// What contacts yield by at present.
    give: f64,
}

impl Scaled {
    /// Rows per contact.
    pub fn stride(&self) -> usize {
        1 + self.tangents
    }

    /// Directions in which friction may act at a contact: there and back along each tangent.
    pub fn facets(&self) -> usize {
        2 * self.tangents
    }

    /// Row within the contact and sign of facet j: -t1, +t1, -t2, +t2. The first opposes the free slip.
    pub fn facet(j: usize) -> (usize, f64) {
        (1 + j / 2, if j.is_multiple_of(2) { -1.0 } else { 1.0 })
    }

    /// The facet that pushes there, or back, along the tangent of row k.
    pub fn facet_along(k: usize, there: bool) -> usize {
        2 * (k - 1) + usize::from(there)
    }

    /// Edge j of the cone of contact i, (1, ±mu d): normal and tangent.
    pub fn edge(&self, i: usize, j: usize) -> Mix {
        let (first, (k, sign)) = (i * self.stride(), Self::facet(j));
        [(first, 1.0), (first + k, sign * self.reach[first + k])]
    }

    /// A~ g of an impulse g along two rows.
    pub fn response(&self, [(k, x), (l, y)]: Mix, response: &mut Vec<f64>) {
        let m = self.drift.len();
        let [a, b] = [k, l].map(|k| &self.delassus[k * m..][..m]);
        response.clear();
        response.extend(a.iter().zip(b).map(|(a, b)| x * a + y * b));
    }

    /// The problem of a law.
    pub fn set(&mut self, problem: &Problem, law: Law) {
        (self.contacts, self.tangents) = (problem.contacts, problem.tangents);
        self.give = 0.0;
        let (m, stride) = (problem.rows(), self.stride());
        self.root.clear();
        self.root.extend(problem.delassus.iter().step_by(m + 1));
        let least = IMMOVABLE * greatest(&self.root);
        self.root.iter_mut().for_each(|a| *a = if *a <= least { 0.0 } else { a.sqrt() });
        self.inverse.clear();
        self.inverse.extend(self.root.iter().map(|&r| if r == 0.0 { 0.0 } else { 1.0 / r }));
        self.drift.clear();
        self.drift.extend(problem.drift.iter().zip(&self.inverse).map(|(b, s)| b * s));
        self.size = greatest(&self.drift);
        self.friction.clone_from(&problem.friction);
        self.ratio.clear();
        self.ratio.resize(m, 1.0);
        self.reach.clear();
        self.reach.resize(m, 0.0);
        for i in 0..problem.contacts {
            let normal = i * stride;
            self.drift[normal] += lift(problem, law, i) * self.inverse[normal];
            for k in normal + 1..normal + stride {
                self.reach[k] = self.friction[i];
                if self.root[k] > 0.0 {
                    self.ratio[k] = self.root[normal] * self.inverse[k];
                    self.reach[k] *= self.inverse[normal] * self.root[k];
                }
            }
        }
        self.delassus.resize(m * m, 0.0);
        let rows = self.delassus.chunks_exact_mut(m.max(1)).zip(problem.delassus.chunks_exact(m.max(1)));
        for ((scaled, row), si) in rows.zip(&self.inverse) {
            scaled.iter_mut().zip(row).zip(&self.inverse).for_each(|((scaled, a), sj)| *scaled = a * (si * sj));
        }
    }

    /// Lets the contacts yield by so much: [`YIELD`], [`HAIR`], or not at all.
    pub fn give(&mut self, give: f64) {
        let (change, next) = (give - self.give, self.drift.len() + 1);
        self.delassus.iter_mut().step_by(next).for_each(|a| *a += change);
        self.give = give;
    }

    /// Whether they yield at present.
    pub fn yields(&self) -> bool {
        self.give > 0.0
    }

    /// Velocity without the yielding: residuals are those of the problem as it was given.
    pub fn harden(&self, impulse: &[f64], velocity: &mut [f64]) {
        if self.yields() {
            velocity.iter_mut().zip(impulse).for_each(|(v, f)| *v -= self.give * f);
        }
    }

    /// Becomes the same problem, in the buffers it has.
    pub fn copy(&mut self, original: &Scaled) {
        (self.contacts, self.tangents, self.size) = (original.contacts, original.tangents, original.size);
        self.give = original.give;
        self.delassus.clone_from(&original.delassus);
        self.drift.clone_from(&original.drift);
        self.root.clone_from(&original.root);
        self.friction.clone_from(&original.friction);
        self.ratio.clone_from(&original.ratio);
        self.reach.clone_from(&original.reach);
    }

    /// Becomes the problem of one proximal round: A + rho I, b - rho f.
    pub fn regularise(&mut self, original: &Scaled, rho: f64, f: &[f64]) {
        self.copy(original);
        self.delassus.iter_mut().step_by(f.len() + 1).for_each(|a| *a += rho);
        self.drift.iter_mut().zip(f).for_each(|(b, f)| *b -= rho * f);
    }

    /// v~ = A~ f~ + b~.
    pub fn velocity(&self, impulse: &[f64], velocity: &mut Vec<f64>) {
        respond(&self.delassus, &self.drift, impulse, velocity);
    }
}

/// v = A f + b, with A symmetric. Columns of what does not push count too: what is no number in them must show.
pub(super) fn respond(delassus: &[f64], drift: &[f64], impulse: &[f64], velocity: &mut Vec<f64>) {
    velocity.clear();
    velocity.extend_from_slice(drift);
    let (v, m) = (&mut velocity[..], drift.len());
    // four rows at a time: each of them would wait until v is in memory again
    let (fours, rest) = impulse.as_chunks::<4>();
    for (k, f) in fours.iter().enumerate() {
        let [a, b, c, d] = std::array::from_fn(|r| &delassus[(4 * k + r) * m..][..v.len()]);
        for i in 0..v.len() {
            v[i] = d[i].mul_add(f[3], c[i].mul_add(f[2], b[i].mul_add(f[1], a[i].mul_add(f[0], v[i]))));
        }
    }
    for (f, row) in rest.iter().zip(delassus[4 * fours.len() * m..].chunks_exact(m.max(1))) {
        v.iter_mut().zip(row).for_each(|(v, a)| *v = a.mul_add(*f, *v));
    }
}

/// Four partial sums, which the compiler can keep in vector registers.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [0.0; 4];
    let (ca, cb) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for k in 0..4 {
            sum[k] += x[k] * y[k];
        }
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}

#[cfg(test)]
mod tests {
    use super::respond;
    use fastrand::Rng;

    #[test]
    fn the_response_is_that_of_column_by_column_and_what_is_no_number_shows() {
        let mut rng = Rng::with_seed(1);
        for m in 0..=9 {
            let [drift, impulse]: [Vec<f64>; 2] = std::array::from_fn(|_| (0..m).map(|_| rng.f64() - 0.5).collect());
            let mut delassus: Vec<f64> = (0..m * m).map(|_| rng.f64() - 0.5).collect();
            let mut expected = drift.clone();
            for (r, f) in impulse.iter().enumerate() {
                expected.iter_mut().enumerate().for_each(|(i, v)| *v = delassus[r * m + i].mul_add(*f, *v));
            }
            let mut found = vec![1.0; 3];
            respond(&delassus, &drift, &impulse, &mut found);
            assert_eq!(found, expected, "{m} rows");
            for r in 0..m {
                let kept = std::mem::replace(&mut delassus[r * m], f64::NAN);
                respond(&delassus, &drift, &vec![0.0; m], &mut found);
                assert!(found[0].is_nan(), "row {r} of {m} pushes nothing");
                delassus[r * m] = kept;
            }
        }
    }
}
