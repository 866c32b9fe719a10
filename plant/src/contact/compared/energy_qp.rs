//! The quadratic program (14)-(16) by an active-set method over the edges of the friction cones. With shifted normal rows it solves
//! Coulomb's law.
//!
//! Along the edges ([`Edges`]), the program is min ½ yᵀQy + qᵀy over y >= 0, with Q = EᵀAE positive semidefinite. Its optimality conditions
//! are `0 <= y ⟂ w = Q y + q >= 0`.
//!
//! The edge with the most negative w becomes basic. A basic amount y that would become negative on the way to the new optimum leaves the
//! basis, and the step continues without it. An edge with negative w is independent of the basic edges, so redundant contacts (singular Q)
//! do no harm.
//!
//! The contacts are compliant ([`ScaledProblem::set_compliance`]). Proximal steps undo the compliance in q, together with rounding errors
//! of w. They converge to the optimum of rigid contacts, and the first one mostly has all digits.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, section 4.2; in the form of Lawson & Hanson's NNLS. Proximal steps:
//! Rockafellar, *Monotone operators and the proximal point algorithm* (1976).

mod conjugate_directions;
mod edges;
mod ratio_test;
pub(super) mod shift_path;
mod shift_responses;
mod sliding;

use super::super::tolerance::{NEGATIVE_VELOCITY, ZERO_AMOUNT};
use super::scaled_problem::ScaledProblem;
use super::status::EDGES;
use super::vector::max_abs;
use conjugate_directions::ConjugateDirections;
use edges::{Edges, Panel, WIDTH, add, index_of, of_contact};
use messages::scene::Law;

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyQp {
    edges: Edges,
    /// Basic edges; and a mask, zero for basic edges and one for the others.
    basic: Vec<usize>,
    idle: Vec<Panel>,
    directions: ConjugateDirections,
    /// \[y; w\]; y is zero for nonbasic edges.
    state: Vec<Panel>,
    /// Direction from the state to the optimum over the basic edges.
    direction: Vec<Panel>,
    /// Mask: zero for edges that failed to become basic since the energy last fell, one for the others.
    candidates: Vec<Panel>,
    /// Remaining amount of each edge after a step.
    remaining: Vec<Panel>,
    /// Edges that are about to leave the basis.
    leaving: Vec<usize>,
    /// Number of basis exchanges since the basis was given.
    pub exchanges: u32,
    /// Impulse of the proximal centre, and the drift with its compliance undone.
    impulse: Vec<f64>,
    drift: Vec<f64>,
}

/// Whether a law minimises the energy, as this program does.
pub(super) fn minimises_energy(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap)
}

impl EnergyQp {
    /// Resets to zero amounts, with the edges of `basis` as the basic edges.
    pub fn reset(&mut self, scaled: &ScaledProblem, basis: &[u8]) {
        self.edges.set(scaled);
        let (count, width) = (self.edges.count(), self.edges.width());
        for list in [&mut self.state, &mut self.direction] {
            list.clear();
            list.resize(2 * width, [0.0; WIDTH]);
        }
        for marks in [&mut self.idle, &mut self.candidates, &mut self.remaining] {
            marks.clear();
            marks.resize(width, [1.0; WIDTH]);
        }
        for list in [&mut self.basic, &mut self.leaving] {
            list.clear();
            list.reserve(count);
        }
        self.directions.clear(width);
        let each = self.edges.each;
        for r in (0..count).filter(|r| basis[r / each] >> (r % each) & 1 == 1) {
            self.make_basic(scaled, r);
        }
        self.exchanges = 0;
    }

    /// Finds the optimum with this shift of the normal rows. Adds the number of entering edges to `count`. False after 20 exchanges per
    /// edge.
    pub fn solve(&mut self, scaled: &ScaledProblem, shift: &[f64], count: &mut u32) -> bool {
        self.candidates.fill([1.0; WIDTH]);
        self.remove_compliance(scaled, shift);
        for _ in 0..20 * self.edges.count() {
            let Some(r) = self.most_negative(scaled) else { return true };
            *count += 1;
            self.enter(scaled, r);
        }
        self.edges.count() == 0
    }

    /// Writes the impulse, and the basic edges as a basis.
    pub fn write(&self, scaled: &ScaledProblem, f: &mut Vec<f64>, basis: &mut [u8]) {
        self.edges.impulse(scaled, &self.basic, self.state.as_flattened(), f);
        basis.fill(EDGES);
        self.basic.iter().for_each(|r| basis[r / self.edges.each] |= 1 << (r % self.edges.each));
    }

    /// Proximal step: undoes the compliance of the present impulse and goes to the optimum over the basic edges. Recomputes w.
    fn remove_compliance(&mut self, scaled: &ScaledProblem, shift: &[f64]) {
        let EnergyQp { edges, basic, directions, state, direction, impulse, drift, .. } = self;
        edges.impulse(scaled, basic, state.as_flattened(), impulse);
        drift.clone_from(&scaled.drift);
        scaled.remove_compliance(impulse, drift);
        drift.iter_mut().step_by(scaled.stride()).zip(shift).for_each(|(v, shift)| *v += shift);
        edges.set_drift(scaled, drift);
        let (y, w) = state.split_at_mut(edges.width());
        edges.velocity(basic, y.as_flattened(), w);
        directions.find_optimum(state, direction);
        self.go_to_optimum();
    }

    /// Makes edge r basic and goes to the optimum. Excludes the edge if that gains nothing.
    fn enter(&mut self, scaled: &ScaledProblem, r: usize) {
        if self.make_basic(scaled, r) {
            self.directions.find_optimum_along_last(&self.state, &mut self.direction);
            self.go_to_optimum();
        }
        if self.is_basic(r) {
            self.candidates.fill([1.0; WIDTH]);
        } else {
            self.candidates[r / WIDTH][r % WIDTH] = 0.0;
        }
    }

    /// Makes edge r basic; false if it depends on the basic edges.
    fn make_basic(&mut self, scaled: &ScaledProblem, r: usize) -> bool {
        let joined = self.directions.append(r, self.edges.row(scaled, r));
        if joined {
            self.basic.push(r);
            self.idle[r / WIDTH][r % WIDTH] = 0.0;
            self.exchanges += 1;
        }
        joined
    }

    /// Makes edge r nonbasic, and removes its part from the direction.
    fn leave(&mut self, r: usize) {
        self.basic.retain(|basic| *basic != r);
        self.idle[r / WIDTH][r % WIDTH] = 1.0;
        self.exchanges += 1;
        self.state[r / WIDTH][r % WIDTH] = 0.0;
        self.directions.remove(r);
        self.directions.project_out(r, &mut self.direction);
    }

    /// Whether edge r is basic.
    fn is_basic(&self, r: usize) -> bool {
        self.idle[r / WIDTH][r % WIDTH] == 0.0
    }

    /// Bit set of the basic edges of a contact.
    fn basic_edges_of(&self, contact: usize) -> u32 {
        let idle = of_contact(&self.idle, contact, self.edges.each);
        idle.iter().rev().fold(0, |bits, idle| bits << 1 | u32::from(*idle == 0.0))
    }

    /// w of all edges.
    fn velocity(&self) -> &[Panel] {
        &self.state[self.edges.width()..]
    }

    /// w of the edges of a contact.
    fn velocity_of(&mut self, contact: usize) -> &mut [f64] {
        let (each, width) = (self.edges.each, self.edges.width());
        &mut self.state[width..].as_flattened_mut()[contact * each..][..each]
    }

    /// The nonbasic edge along which the energy falls fastest.
    fn most_negative(&self, scaled: &ScaledProblem) -> Option<usize> {
        let panels = self.edges.speeds(self.velocity()).zip(self.candidates.iter().zip(&self.idle));
        let free = panels.map(|(speeds, (open, idle))| -> Panel {
            std::array::from_fn(|k| speeds[k] * (open[k] * idle[k])) // a product instead of a branch
        });
        let least = free.clone().fold([0.0; WIDTH], |least: Panel, speeds| {
            std::array::from_fn(|k| if speeds[k] < least[k] { speeds[k] } else { least[k] })
        });
        let least = edges::least(&least);
        if least >= -NEGATIVE_VELOCITY * self.scale(scaled) {
            return None;
        }
        free.enumerate().find_map(|(p, speeds)| Some(p * WIDTH + index_of(least, &speeds)?))
    }

    /// The scale of the step.
    fn scale(&self, scaled: &ScaledProblem) -> f64 {
        scaled.size.max(max_abs(self.state[..self.edges.width()].as_flattened()))
    }

    /// Goes along the direction to its end. Edges whose amounts would become negative leave the basis, and the step continues without them.
    fn go_to_optimum(&mut self) {
        for _ in 0..=self.edges.count() {
            let EnergyQp { basic, state, direction, remaining, leaving, .. } = self;
            let Some(share) = share(state, direction) else {
                return add(state, 1.0, direction);
            };
            find_remaining(state, direction, share, remaining);
            leaving.clear();
            leaving.extend(basic.iter().filter(|&&r| remaining[r / WIDTH][r % WIDTH] <= 0.0));
            add(state, share, direction);
            if leaving.is_empty() {
                return;
            }
            direction.as_flattened_mut().iter_mut().for_each(|z| *z *= 1.0 - share);
            while let Some(r) = self.leaving.pop() {
                self.leave(r);
            }
        }
    }
}

/// For each amount, the greater of its value after this share of the direction and its value at the end. An amount that
/// becomes negative on the way is then zero or less. The code has no branches, because a processor could not predict them.
fn find_remaining(state: &[Panel], direction: &[Panel], share: f64, remaining: &mut [Panel]) {
    for (remaining, (y, z)) in remaining.iter_mut().zip(state.iter().zip(direction)) {
        *remaining = std::array::from_fn(|k| {
            let end = y[k] + z[k];
            let most = if y[k] > -end { y[k] } else { -end };
            let rest = z[k].mul_add(share, y[k]) - ZERO_AMOUNT * most;
            if rest > end { rest } else { end }
        });
    }
}

/// Share of the direction at which the first amount becomes zero, if any does.
fn share(state: &[Panel], direction: &[Panel]) -> Option<f64> {
    let width = state.len() / 2;
    let least = state[..width].iter().zip(direction).fold([f64::INFINITY; WIDTH], |least: Panel, (y, z)| {
        std::array::from_fn(|k| {
            // 0/0 is NaN and compares as false
            let share = if y[k] + z[k] > 0.0 { f64::INFINITY } else { y[k] / -z[k] };
            if share < least[k] { share } else { least[k] }
        })
    });
    let least = edges::least(&least);
    (least < f64::INFINITY).then_some(least.min(1.0))
}
