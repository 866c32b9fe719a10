//! The quadratic program (14)-(16) as printed, and with shifted normal rows Coulomb's law: an active set over the edges of the cones.
//!
//! Along the edges ([`Edges`]) it is min ½ yᵀQy + qᵀy over y >= 0 with Q = EᵀAE positive semidefinite, and its conditions are
//! `0 <= y ⟂ w = Q y + q >= 0`.
//!
//! The edge with the most negative w joins the basic ones; a basic y that would become negative on the way to the new optimum
//! leaves, and the way goes on without it. An edge whose w is still negative is independent of the basic ones, so redundant contacts
//! (singular Q) do no harm.
//!
//! At the optimum contacts have yielded to the impulse ([`ScaledProblem::compliance`]). A proximal step undoes that in q, and what w has lost to
//! rounding: the limit is the optimum of rigid contacts, and the first step mostly has all its digits.
//!
//! # Source
//! Cottle, Pang & Stone, *The Linear Complementarity Problem*, section 4.2; in the form of Lawson & Hanson's NNLS. Proximal steps:
//! Rockafellar, *Monotone operators and the proximal point algorithm* (1976).

mod conjugate_directions;
mod edges;
mod ratio_test;
mod shift_path;
mod shift_responses;
mod sliding;

use super::super::tolerance::{NEGATIVE_VELOCITY, ZERO_AMOUNT};
use super::scaled_problem::ScaledProblem;
use super::square_cone::max_abs;
use super::status::EDGES;
use conjugate_directions::ConjugateDirections;
use edges::{Edges, Panel, WIDTH, add, index_of, of_contact};
use messages::scene::Law;
pub(super) use shift_path::ShiftPath;

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct EnergyQp {
    edges: Edges,
    /// Edges that may push, and zero for each of them, one for the others.
    basic: Vec<usize>,
    idle: Vec<Panel>,
    directions: ConjugateDirections,
    /// \[y; w\]; y is zero of what is not basic.
    state: Vec<Panel>,
    /// What leads from there to the optimum over the basic edges.
    direction: Vec<Panel>,
    /// Zero for edges that could not join since the energy last fell, one for the others.
    candidates: Vec<Panel>,
    /// What is left of each amount where something ceases to push.
    remaining: Vec<Panel>,
    /// Those that are about to leave.
    leaving: Vec<usize>,
    /// How often an edge has joined or left since the basis was given.
    pub exchanges: u32,
    /// What contacts push by, and the drift with what that undoes.
    impulse: Vec<f64>,
    drift: Vec<f64>,
}

/// Whether a law is this program.
pub(super) fn minimises_energy(law: Law) -> bool {
    matches!(law, Law::EnergyQp | Law::EnergyQpGap)
}

impl EnergyQp {
    /// No amount of any edge, and those of the basis basic.
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
        self.basic.clear();
        self.directions.clear(width);
        let each = self.edges.each;
        for r in (0..count).filter(|r| basis[r / each] >> (r % each) & 1 == 1) {
            self.make_basic(scaled, r);
        }
        self.exchanges = 0;
    }

    /// Goes on to the optimum with this shift of the normal rows. Adds those that join to `count`; false if there are more than 20 an
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

    /// Writes the impulse, and as a basis the edges that push.
    pub fn write(&self, scaled: &ScaledProblem, f: &mut Vec<f64>, basis: &mut [u8]) {
        self.edges.impulse(scaled, &self.basic, self.state.as_flattened(), f);
        basis.fill(EDGES);
        self.basic.iter().for_each(|r| basis[r / self.edges.each] |= 1 << (r % self.edges.each));
    }

    /// The optimum over the basic edges where what contacts have yielded by so far is undone; w is made afresh.
    fn remove_compliance(&mut self, scaled: &ScaledProblem, shift: &[f64]) {
        let EnergyQp { edges, basic, directions, state, direction, impulse, drift, .. } = self;
        edges.impulse(scaled, basic, state.as_flattened(), impulse);
        drift.clone_from(&scaled.drift);
        scaled.remove_compliance(impulse, drift);
        drift.iter_mut().step_by(scaled.stride()).zip(shift).for_each(|(v, shift)| *v += shift);
        edges.set_drift(scaled, drift);
        let (y, w) = state.split_at_mut(edges.width());
        edges.velocity(basic, y.as_flattened(), w);
        directions.to_optimum(state, direction);
        self.go_to_optimum();
    }

    /// Makes edge r basic and goes to the optimum; bars it if that gains nothing.
    fn enter(&mut self, scaled: &ScaledProblem, r: usize) {
        if self.make_basic(scaled, r) {
            self.directions.to_optimum_along_last(&self.state, &mut self.direction);
            self.go_to_optimum();
        }
        if self.is_basic(r) {
            self.candidates.fill([1.0; WIDTH]);
        } else {
            self.candidates[r / WIDTH][r % WIDTH] = 0.0;
        }
    }

    /// Makes edge r basic; false if it depends on those that are.
    fn make_basic(&mut self, scaled: &ScaledProblem, r: usize) -> bool {
        let joined = self.directions.append(r, self.edges.row(scaled, r));
        if joined {
            self.basic.push(r);
            self.idle[r / WIDTH][r % WIDTH] = 0.0;
            self.exchanges += 1;
        }
        joined
    }

    /// Edge r is no longer basic, and the course goes on without it.
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

    /// A bit for each edge of a contact that is basic.
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

    /// The edge outside the basis along which the energy falls most.
    fn most_negative(&self, scaled: &ScaledProblem) -> Option<usize> {
        let panels = self.edges.speeds(self.velocity()).zip(self.candidates.iter().zip(&self.idle));
        let free = panels.map(|(speeds, (open, idle))| -> Panel {
            std::array::from_fn(|k| speeds[k] * (open[k] * idle[k])) // a choice would be a branch for each
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

    /// The step's scale.
    fn scale(&self, scaled: &ScaledProblem) -> f64 {
        scaled.size.max(max_abs(self.state[..self.edges.width()].as_flattened()))
    }

    /// Follows the course to its end; those that become negative on the way leave, and it goes on without them.
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

/// Of each amount what is left after so much of a course or at its end, whichever is more: no more than zero of those only that
/// become negative on the way. Of all at once, for a processor cannot guess which they are.
fn find_remaining(state: &[Panel], direction: &[Panel], share: f64, remaining: &mut [Panel]) {
    for (remaining, (y, z)) in remaining.iter_mut().zip(state.iter().zip(direction)) {
        *remaining = std::array::from_fn(|k| {
            let goal = y[k] + z[k];
            let most = if y[k] > -goal { y[k] } else { -goal };
            let rest = z[k].mul_add(share, y[k]) - ZERO_AMOUNT * most;
            if rest > goal { rest } else { goal }
        });
    }
}

/// How far a course can be followed before something ceases to push, if anything does on the way.
fn share(state: &[Panel], direction: &[Panel]) -> Option<f64> {
    let width = state.len() / 2;
    let least = state[..width].iter().zip(direction).fold([f64::INFINITY; WIDTH], |least: Panel, (y, z)| {
        std::array::from_fn(|k| {
            // of nothing from nothing, which is no number, nothing is known
            let share = if y[k] + z[k] > 0.0 { f64::INFINITY } else { y[k] / -z[k] };
            if share < least[k] { share } else { least[k] }
        })
    });
    let least = edges::least(&least);
    (least < f64::INFINITY).then_some(least.min(1.0))
}
