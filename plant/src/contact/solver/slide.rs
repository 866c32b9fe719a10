//! Coulomb's law by the energy program (14)-(16), whose normal rows are shifted until they are what they should be.
//!
//! Each round the shift of a contact grows to mu |v_F| of the last solution. Without exaggeration it comes nearer by a factor
//! each round; where a foot turns against what hardly yields the factor is almost one, and thousands of rounds would ask for
//! the same small change.

use super::super::scaled::YIELD;
use super::super::{active_set, residual};
use super::{SOLVED, Solver, yardstick};
use messages::scene::Law;

/// How the shifted energy program is tried.
struct Way {
    rounds: usize,
    /// How shifts grow.
    growth: Growth,
    /// What contacts yield by.
    give: f64,
}

/// Most steps need one round, few the second way. There contacts are rigid: what yields creeps as shifts do.
const WAYS: [Way; 4] = [
    Way { rounds: 6, growth: Growth::Plain, give: YIELD },
    Way { rounds: 60, growth: Growth::Each, give: 0.0 },
    Way { rounds: 40, growth: Growth::Common(10), give: 0.0 },
    Way { rounds: 400, growth: Growth::Each, give: YIELD },
];
/// Greatest exaggeration of all shifts together.
const MOST: f64 = 64.0;

/// How shifts grow from round to round.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Growth {
    /// To the slip that they caused.
    Plain,
    /// Twice as far beyond it each time that this is asked for again undiminished, each by itself.
    Each,
    /// The same together, as long as the residual stays, from this round on.
    Common(usize),
}

impl Growth {
    /// How far all shifts go beyond the slip that they caused, after they went `boost` in the round before.
    fn boost(self, round: usize, boost: f64, stays: bool) -> f64 {
        match self {
            Growth::Common(from) if stays && round >= from => f64::min(2.0 * boost, MOST),
            _ => 1.0,
        }
    }
}

/// What is added to the v_N of a contact: mu |v_F| in the end.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Shift {
    value: f64,
    /// The last change that was asked for, and by how much it was exaggerated.
    change: f64,
    boost: f64,
}

impl Shift {
    /// Goes to the slip that it caused, or as far beyond as `boost` says; without it, twice as far each time that the
    /// change is asked for again undiminished.
    fn approach(&mut self, slip: f64, boost: Option<f64>) {
        let change = slip - self.value;
        let again = change * self.change > 0.5 * self.change * self.change;
        self.boost = boost.unwrap_or(if again { 2.0 * self.boost } else { 1.0 });
        self.change = change;
        self.value = (self.value + self.boost * change).max(0.0);
    }
}

impl Solver {
    /// The energy program (14)-(16), with mu |v_F| of its last solution added to each v_N until nothing changes.
    ///
    /// Its optimum has v_N >= mu |v_F|: that is Coulomb's law where nothing slides, and the shift makes it so where
    /// something does (De Saxcé; Acary & Cadoux). Long before the shift has settled the optimum says what slides where,
    /// and the block has the solution. Where a foot turns against what hardly yields, shifts grow by the same little each
    /// round: they are exaggerated, in one of the [`WAYS`] after the other.
    ///
    /// Each round also undoes what contacts yielded by in the one before (a proximal step), so that the limit is the
    /// solution of rigid ones.
    pub(super) fn slide(&mut self, law: Law, pivots: &mut u32) -> bool {
        for bits in &mut self.basis {
            *bits = active_set::rays(*bits, self.scaled.facets());
        }
        self.rays.clone_from(&self.basis);
        WAYS.iter().any(|way| {
            self.scaled.give(way.give);
            self.slide_by(way.rounds, way.growth, law, pivots)
        })
    }

    fn slide_by(&mut self, rounds: usize, growth: Growth, law: Law, pivots: &mut u32) -> bool {
        let stride = self.scaled.stride();
        self.proximal.copy(&self.scaled);
        self.shift.clear();
        self.shift.resize(self.scaled.contacts, Shift::default());
        let (mut boost, mut before) = (1.0, f64::INFINITY);
        for round in 0..rounds {
            let Solver { scaled, shift, proximal, energy_qp, block, f, v, basis, rays, .. } = self;
            basis.clone_from(rays);
            if !energy_qp.pivot(proximal, block, basis, f, v, round > 0, pivots) {
                return false;
            }
            rays.clone_from(basis);
            for (v, (shifted, b)) in v.iter_mut().zip(proximal.drift.iter().zip(&scaled.drift)) {
                *v -= shifted - b;
            }
            scaled.harden(f, v);
            let error = residual::natural_map(scaled, f, v, yardstick(law));
            basis.iter_mut().for_each(|bits| *bits |= active_set::RAYS);
            if error <= SOLVED {
                return true;
            }
            boost = growth.boost(round, boost, error > 0.5 * before);
            before = error;
            scaled.lead(f, &mut proximal.drift);
            for (i, (v, shift)) in v.chunks_exact(stride).zip(shift).enumerate() {
                shift.approach(residual::slip(scaled, i, v), (growth != Growth::Each).then_some(boost));
                proximal.drift[i * stride] += shift.value;
            }
            active_set::slide(scaled, f, v, basis);
            self.note(error);
            if self.is_solved(law) || usize::is_power_of_two(round + 1) && self.settle(law, pivots) {
                return true;
            }
        }
        false
    }
}
