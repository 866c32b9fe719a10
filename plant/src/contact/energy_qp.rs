//! The quadratic program (14)-(16) as printed, by principal pivoting.
//!
//! Each cone is spanned by its edge rays (1, ±mu d): f = Σ y_j (1, mu d_j), y >= 0. Then (14) is min ½ yᵀQy + qᵀy with
//! Q = RᵀAR positive semidefinite, and its conditions are `0 <= y ⟂ w = Q y + q >= 0`.
//!
//! The ray with the most negative w joins the basic ones; a basic y that would become negative on the way to the new
//! optimum leaves first. A ray whose w is still negative is independent of the basic ones, so redundant contacts
//! (singular Q) do no harm. Every basis is solved afresh, for in a tableau the small pivots of nearly redundant contacts,
//! two flat feet on one robot, would magnify rounding from one exchange to the next.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, section 4.2; in the form of Lawson & Hanson's NNLS.

use super::basis::{Block, in_contact};
use super::residual;
use super::scaled::Scaled;
use messages::scene::Law;

/// A negative w this small, relative to the step's scale, is rounding.
const ROUNDING: f64 = 1e-12;

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyQp {
    /// y of each ray, zero where it is not basic.
    amount: Vec<f64>,
    /// Rays that could not join since the energy last fell.
    barred: Vec<bool>,
    /// Basic rays, each with its y at the optimum over them.
    goals: Vec<(usize, f64)>,
}

/// Whether a law is this program.
pub(super) fn minimises_energy(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap)
}

/// Ray j of contact i in scaled rows.
pub(super) fn ray(scaled: &Scaled, i: usize, j: usize) -> [f64; 3] {
    let (k, sign) = Scaled::facet(j);
    let mut ray = [1.0, 0.0, 0.0];
    ray[k] = sign * scaled.friction[i] / scaled.ratio[i * scaled.stride() + k];
    ray
}

impl EnergyQp {
    /// Solves; writes impulse, velocity and basis, one bit per basic ray. Adds the pivots to `count`; false beyond 20
    /// per ray. Starts from the given basis, when asked `again` also from the last solution.
    #[expect(clippy::too_many_arguments, reason = "problem and solution, their workspace, and the count")]
    pub fn pivot(
        &mut self,
        scaled: &Scaled,
        block: &mut Block,
        basis: &mut [u8],
        f: &mut Vec<f64>,
        v: &mut Vec<f64>,
        again: bool,
        count: &mut u32,
    ) -> bool {
        let d = scaled.facets();
        let rays = scaled.contacts * d;
        if self.amount.len() != rays || !again {
            self.amount.clear();
            self.amount.resize(rays, 0.0);
        }
        self.barred.clear();
        self.barred.resize(rays, false);
        self.descend(scaled, block, basis, f, v);
        for _ in 0..20 * rays {
            let Some(joins) = self.most_negative(scaled, basis, f, v) else {
                return block.solve(scaled, Law::EnergyQp, basis, f, v);
            };
            *count += 1;
            basis[joins / d] |= 1 << (joins % d);
            let moved = self.descend(scaled, block, basis, f, v);
            if moved && basis[joins / d] >> (joins % d) & 1 == 1 {
                self.barred.fill(false);
            } else {
                self.barred[joins] = true;
                basis[joins / d] &= !(1 << (joins % d));
                self.amount[joins] = 0.0;
                block.estimate(scaled, Law::EnergyQp, basis, f, v);
            }
        }
        false
    }

    /// The ray outside the basis along which the energy falls most.
    fn most_negative(&self, scaled: &Scaled, basis: &[u8], f: &[f64], v: &[f64]) -> Option<usize> {
        let (d, stride) = (scaled.facets(), scaled.stride());
        let least = ROUNDING * residual::scale(scaled, f);
        (0..self.amount.len())
            .filter(|&r| basis[r / d] >> (r % d) & 1 == 0 && !self.barred[r])
            .map(|r| {
                let ray = ray(scaled, r / d, r % d);
                let length = ray.iter().map(|x| x * x).sum::<f64>().sqrt();
                (r, in_contact(&ray, &v[r / d * stride..]) / length)
            })
            .filter(|(_, w)| *w < -least)
            .min_by(|(_, a), (_, b)| a.total_cmp(b))
            .map(|(r, _)| r)
    }

    /// Goes to the optimum over the basic rays, dropping those that become negative on the way. False if there is none.
    fn descend(
        &mut self,
        scaled: &Scaled,
        block: &mut Block,
        basis: &mut [u8],
        f: &mut Vec<f64>,
        v: &mut Vec<f64>,
    ) -> bool {
        let d = scaled.facets();
        for _ in 0..self.amount.len() {
            if !block.estimate(scaled, Law::EnergyQp, basis, f, v) {
                return false;
            }
            let basic = (0..self.amount.len()).filter(|&r| basis[r / d] >> (r % d) & 1 == 1);
            self.goals.clear();
            self.goals.extend(basic.zip(block.amounts().iter().copied()));
            let reach = |&(r, goal): &(usize, f64)| {
                if goal > 0.0 { 1.0 } else { self.amount[r] / (self.amount[r] - goal) }
            };
            let share = self.goals.iter().map(reach).fold(1.0, f64::min);
            let share = if share.is_nan() { 0.0 } else { share };
            for &(r, goal) in &self.goals {
                let moved = self.amount[r] + share * (goal - self.amount[r]);
                let leaves = goal <= 0.0 && moved <= 1e-14 * self.amount[r].max(goal.abs());
                self.amount[r] = if leaves { 0.0 } else { moved };
                if leaves {
                    basis[r / d] &= !(1 << (r % d));
                }
            }
            if share == 1.0 {
                return true;
            }
        }
        false
    }
}
