//! The contact problem in energy units. Rows and columns are scaled by diag(A)^-1/2, so that A has a unit diagonal, and impulses and
//! velocities are both in sqrt(J).

use super::super::law::approach_offset;
use super::super::problem::Problem;
use super::super::round_cones::{RoundCones, apply_delassus};
use super::super::tolerance::IMMOVABLE;
use super::vector::max_abs;
use messages::scene::Law;

/// Two rows of the problem with weights.
pub(super) type RowPair = [(usize, f64); 2];

/// `v = A f + b` scaled: f~ = sqrt(A_kk) f, v~ = v / sqrt(A_kk). A direction without motion has a zero row and zero impulse.
#[derive(Clone, Debug, Default)]
pub(super) struct ScaledProblem {
    pub contacts: usize,
    pub tangents: usize,
    /// A~, m by m.
    pub delassus: Vec<f64>,
    /// b~, with the allowed approach added to the normal rows.
    pub drift: Vec<f64>,
    /// sqrt(A_kk), zero where immovable.
    pub root: Vec<f64>,
    /// μ of each contact.
    pub friction: Vec<f64>,
    /// For each tangent row c = sqrt(A_NN / A_kk), so that the cone reads sum c |f~_k| <= μ f~_N.
    pub ratio: Vec<f64>,
    /// μ / c of each tangent row: slope of the cone along that tangent.
    pub cone_slope: Vec<f64>,
    /// Largest scaled drift.
    pub size: f64,
    /// 1 / root, zero where immovable.
    pub inverse: Vec<f64>,
    /// Present compliance, included in A~ [-].
    compliance: f64,
}

impl ScaledProblem {
    /// Rows per contact.
    pub fn stride(&self) -> usize {
        1 + self.tangents
    }

    /// Directions of friction at a contact: two per tangent.
    pub fn facets(&self) -> usize {
        2 * self.tangents
    }

    /// Row within the contact and sign of facet j: -t1, +t1, -t2, +t2. The first opposes the free slip.
    pub fn facet(j: usize) -> (usize, f64) {
        (1 + j / 2, if j.is_multiple_of(2) { -1.0 } else { 1.0 })
    }

    /// The facet that pushes along the tangent of row k, in its positive or negative direction.
    pub fn facet_along(k: usize, positive: bool) -> usize {
        2 * (k - 1) + usize::from(positive)
    }

    /// Edge j of the cone of contact i, (1, ±μ d): its normal and tangential rows.
    pub fn edge(&self, i: usize, j: usize) -> RowPair {
        let (first, (k, sign)) = (i * self.stride(), Self::facet(j));
        [(first, 1.0), (first + k, sign * self.cone_slope[first + k])]
    }

    /// A~ g of an impulse g along two rows.
    pub fn response(&self, [(k, x), (l, y)]: RowPair, response: &mut Vec<f64>) {
        let m = self.drift.len();
        let [a, b] = [k, l].map(|k| &self.delassus[k * m..][..m]);
        response.clear();
        response.extend(a.iter().zip(b).map(|(a, b)| x * a + y * b));
    }

    /// Sets the problem of a law.
    pub fn set(&mut self, problem: &Problem, law: Law) {
        (self.contacts, self.tangents) = (problem.contacts, problem.tangents);
        self.compliance = 0.0;
        let (m, stride) = (problem.rows(), self.stride());
        self.root.clear();
        self.root.extend(problem.delassus.iter().step_by(m + 1));
        let least = IMMOVABLE * max_abs(&self.root);
        self.root.iter_mut().for_each(|a| *a = if *a <= least { 0.0 } else { a.sqrt() });
        self.inverse.clear();
        self.inverse.extend(self.root.iter().map(|&r| if r == 0.0 { 0.0 } else { 1.0 / r }));
        self.drift.clear();
        self.drift.extend(problem.drift.iter().zip(&self.inverse).map(|(b, s)| b * s));
        self.size = max_abs(&self.drift);
        self.friction.clone_from(&problem.friction);
        self.ratio.clear();
        self.ratio.resize(m, 1.0);
        self.cone_slope.clear();
        self.cone_slope.resize(m, 0.0);
        for i in 0..problem.contacts {
            let normal = i * stride;
            self.drift[normal] += approach_offset(problem, law, i) * self.inverse[normal];
            for k in normal + 1..normal + stride {
                self.cone_slope[k] = self.friction[i];
                if self.root[k] > 0.0 {
                    self.ratio[k] = self.root[normal] * self.inverse[k];
                    self.cone_slope[k] *= self.inverse[normal] * self.root[k];
                }
            }
        }
        self.delassus.resize(m * m, 0.0);
        let rows = self.delassus.chunks_exact_mut(m.max(1)).zip(problem.delassus.chunks_exact(m.max(1)));
        for ((scaled, row), si) in rows.zip(&self.inverse) {
            scaled.iter_mut().zip(row).zip(&self.inverse).for_each(|((scaled, a), sj)| *scaled = a * (si * sj));
        }
    }

    /// Sets a problem for round cones, in which the rows of a contact have a common scale.
    pub fn set_alike(&mut self, cones: &RoundCones) {
        (self.contacts, self.tangents, self.size, self.compliance) = (cones.contacts, 2, cones.size, 0.0);
        self.delassus.clone_from(&cones.delassus);
        self.drift.clone_from(&cones.drift);
        self.friction.clone_from(&cones.friction);
        self.ratio.clear();
        self.ratio.resize(self.drift.len(), 1.0);
    }

    /// Sets the compliance of all contacts.
    pub fn set_compliance(&mut self, compliance: f64) {
        let (change, next) = (compliance - self.compliance, self.drift.len() + 1);
        self.delassus.iter_mut().step_by(next).for_each(|a| *a += change);
        self.compliance = compliance;
    }

    /// Whether the contacts are compliant.
    fn is_compliant(&self) -> bool {
        self.compliance > 0.0
    }

    /// Removes the effect of the compliance from a velocity: residuals are those of rigid contacts.
    pub fn remove_compliance(&self, impulse: &[f64], velocity: &mut [f64]) {
        if self.is_compliant() {
            velocity.iter_mut().zip(impulse).for_each(|(v, f)| *v -= self.compliance * f);
        }
    }

    /// v~ = A~ f~ + b~.
    pub fn velocity(&self, impulse: &[f64], velocity: &mut Vec<f64>) {
        apply_delassus(&self.delassus, &self.drift, impulse, velocity);
    }
}
