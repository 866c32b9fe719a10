//! The quadratic program (14)-(16) as printed, by principal pivoting.
//!
//! Along the edges of the cones ([`Rays`]) it is min ½ yᵀQy + qᵀy over y >= 0 with Q = RᵀAR positive semidefinite, and its
//! conditions are `0 <= y ⟂ w = Q y + q >= 0`.
//!
//! The ray with the most negative w joins the basic ones; a basic y that would become negative on the way to the new
//! optimum leaves first. A ray whose w is still negative is independent of the basic ones, so redundant contacts
//! (singular Q) do no harm. The factor of the basic rays follows what joins and leaves ([`Growing`]); in a tableau the small
//! pivots of nearly redundant contacts, two flat feet on one robot, would magnify rounding from one exchange to the next.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, section 4.2; in the form of Lawson & Hanson's NNLS.

use super::growing::Growing;
use super::rays::Rays;
use super::scaled::Scaled;
use messages::scene::Law;

/// A negative w this small, relative to the step's scale, is rounding.
const ROUNDING: f64 = 1e-12;

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyQp {
    rays: Rays,
    /// Rays that may push, in the order in which they joined.
    basic: Vec<usize>,
    factor: Growing,
    /// y of each ray, zero where it is not basic.
    amount: Vec<f64>,
    /// y of each basic ray at the optimum over them.
    goal: Vec<f64>,
    /// w there.
    velocity: Vec<f64>,
    /// Rays that could not join since the energy last fell.
    barred: Vec<bool>,
    /// Rays that are about to leave, and those that joined after the first of them.
    leaving: Vec<bool>,
    behind: Vec<usize>,
}

/// Whether a law is this program.
pub(super) fn minimises_energy(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap)
}

impl EnergyQp {
    /// Solves the problem with this drift; writes impulse and basis, one bit per basic ray. Adds the pivots to `count`; false beyond
    /// 20 per ray. Starts from the given basis, when asked `again`, which means with another drift, from where the last one ended.
    pub fn pivot(
        &mut self,
        scaled: &Scaled,
        drift: &[f64],
        basis: &mut [u8],
        f: &mut Vec<f64>,
        again: bool,
        count: &mut u32,
    ) -> bool {
        if !again {
            self.begin(scaled, basis);
        }
        self.rays.turn(scaled, drift);
        self.barred.fill(false);
        self.descend(scaled);
        for _ in 0..20 * self.rays.count() {
            let Some(joins) = self.most_negative(scaled) else {
                self.write(scaled, basis);
                self.rays.push(scaled, &self.basic, &self.goal, f);
                return true;
            };
            *count += 1;
            let moved = self.join(scaled, joins) && self.descend(scaled);
            if moved && self.basic.contains(&joins) {
                self.barred.fill(false);
            } else {
                self.barred[joins] = true;
                self.leaving[joins] = true;
                self.leave(scaled);
                self.aim();
            }
        }
        false
    }

    /// No amount of any ray, and those of the basis basic.
    fn begin(&mut self, scaled: &Scaled, basis: &[u8]) {
        self.rays.set(scaled);
        let count = self.rays.count();
        self.amount.clear();
        self.amount.resize(count, 0.0);
        for marks in [&mut self.barred, &mut self.leaving] {
            marks.clear();
            marks.resize(count, false);
        }
        self.basic.clear();
        self.factor.clear(count);
        for r in (0..count).filter(|r| basis[r / scaled.facets()] >> (r % scaled.facets()) & 1 == 1) {
            self.join(scaled, r);
        }
    }

    /// The basic rays as bits.
    fn write(&self, scaled: &Scaled, basis: &mut [u8]) {
        basis.fill(0);
        self.basic.iter().for_each(|r| basis[r / scaled.facets()] |= 1 << (r % scaled.facets()));
    }

    /// Makes ray r basic; false if it depends on those that are.
    fn join(&mut self, scaled: &Scaled, r: usize) -> bool {
        let row = self.rays.row(scaled, r);
        let joined = self.factor.join(self.basic.iter().chain([&r]).map(|&k| row[k]));
        if joined {
            self.basic.push(r);
        }
        joined
    }

    /// Lets those go that are about to leave; those behind the first of them join anew, in their order.
    fn leave(&mut self, scaled: &Scaled) {
        let Some(first) = self.basic.iter().position(|&r| self.leaving[r]) else { return };
        self.factor.truncate(first);
        self.behind.clear();
        self.behind.extend(self.basic.drain(first..));
        for at in 0..self.behind.len() {
            let r = self.behind[at];
            if self.leaving[r] || !self.join(scaled, r) {
                (self.leaving[r], self.amount[r]) = (false, 0.0);
            }
        }
    }

    /// The optimum over the basic rays.
    fn aim(&mut self) {
        self.goal.clear();
        self.goal.extend(self.basic.iter().map(|&r| -self.rays.drift(r)));
        self.factor.solve(&mut self.goal);
    }

    /// The ray outside the basis along which the energy falls most.
    fn most_negative(&mut self, scaled: &Scaled) -> Option<usize> {
        let EnergyQp { rays, basic, goal, velocity, barred, .. } = self;
        rays.velocity(basic, goal, velocity);
        basic.iter().for_each(|&r| velocity[r] = 0.0);
        let scale = goal.iter().fold(scaled.size, |size, y| size.max(*y));
        let (mut least, mut joins) = (-ROUNDING * scale, None);
        for (r, (speed, barred)) in rays.speeds(velocity).zip(&*barred).enumerate() {
            if speed < least && !barred {
                (least, joins) = (speed, Some(r));
            }
        }
        joins
    }

    /// Goes to the optimum over the basic rays, dropping those that become negative on the way. False if there is none.
    fn descend(&mut self, scaled: &Scaled) -> bool {
        for _ in 0..self.amount.len() {
            self.aim();
            let reach = |(&r, &goal): (&usize, &f64)| {
                if goal > 0.0 { 1.0 } else { self.amount[r] / (self.amount[r] - goal) }
            };
            let share = self.basic.iter().zip(&self.goal).map(reach).fold(1.0, f64::min);
            let share = if share.is_nan() { 0.0 } else { share };
            let mut all_stay = true;
            for (&r, &goal) in self.basic.iter().zip(&self.goal) {
                let moved = self.amount[r] + share * (goal - self.amount[r]);
                self.leaving[r] = goal <= 0.0 && moved <= 1e-14 * self.amount[r].max(goal.abs());
                self.amount[r] = moved;
                all_stay &= !self.leaving[r];
            }
            if all_stay && share == 1.0 {
                return true;
            }
            self.leave(scaled);
        }
        false
    }
}
