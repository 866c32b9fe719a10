//! Coulomb's law with the round cone, (17)-(22): the law `Cone`.
//!
//! ```text
//!   solve(problem, memory):
//!     recall             mode, impulse and slip of each contact in the last step
//!     Newton             from there, releasing patches that do not hold; then, near a solution,
//!                        from the best impulse so far, with balanced weights                     (newton, patch)
//!     friction in steps  where μ > 1: Newton and interior points with less friction, then Newton
//!                        with more, up to that of the problem                                    (friction_steps)
//!     interior points    and Newton from the modes that they indicate                            (interior)
//!     few contacts       the above over a selection of contacts, until no other one enters the ground (few_contacts)
//!     patient attempts   interior points with cautious steps, then Newton from the memory;
//!                        both may take more steps, and their contacts are hardly compliant;
//!                        then Newton from the memory again, with the usual compliance
//!     least squares      of the natural map, with several weights, from the best impulse so far,
//!                        each followed by Newton                                                 (least_squares)
//!     energy minima      with De Saxcé's shift held, each followed by Newton, until the shift
//!                        equals μ times the slip speed                                           (held_shift)
//!     random starts      of both: least squares from random impulses, minima from random shifts
//!     random weights     Newton from the best impulse, with random weights and compliances
//!     store              the impulse with the least residual, and the modes of its contacts      (certificate)
//! ```
//!
//! The stages form a cascade. A stage runs only if no impulse so far meets the certificate: the natural map of the round cone, for the
//! problem as posed. If the last stage fails too, the report has `fallback` set. Before this solver, the step tries the case that all feet
//! stand, which needs no A: [`crate::standing`].
//!
//! Some problems have several solutions. Among impulses with the same effect, every stage takes the one of least norm over each link,
//! distributed as [`patch`] describes. Where the normal velocities of several links are dependent, as those of four wheels, Newton's method takes
//! the normal impulses of least norm over all links. Among other motions, every stage takes the first that it finds, starting from the modes of the
//! step before; where a landing splits a step, from the points that land. So a contact that sticks and is pressed to the ground stays, though it
//! would rise without contact; [`crate::standing`] does the same.

mod few_contacts;
mod friction_steps;
mod held_shift;
mod interior;
mod iterate;
mod least_squares;
mod natural_map;
mod newton;
mod patch;
mod reserve;
#[cfg(test)]
mod tests;

use super::memory::{LastContact, Memory};
use super::mode::ContactMode;
use super::problem::Problem;
use super::report::Report;
use super::round_cones::{RoundCones, contact_rows};
use super::tolerance::{
    COMPLIANCE_DECADES, FIRST_MINIMA, MASS_DECADES, MAX_RANDOM_STARTS, MIN_RANDOM_STARTS, NEAR_SOLUTION, PROMISED,
    RANDOM_START_ROWS, RESTART_MINIMA, SOLVED, START_DECADES, WEIGHT_DECADES, WEIGHTED_RUNS, WEIGHTS,
};
use fastrand::Rng;
use held_shift::HeldShift;
use interior::{Interior, StepRule};
use iterate::{Guess, Iterate, Limits, Start, Weight};
use least_squares::LeastSquares;
use messages::scene::Law;
use newton::PatchNewton;

/// Seed of the random starts: the same in every step, so that equal problems have equal solutions.
const SEED: u64 = 1;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Coulomb {
    cones: RoundCones,
    newton: PatchNewton,
    interior: Interior,
    least_squares: LeastSquares,
    shift: HeldShift,
    guess: Guess,
    /// Modes with which Newton's method was last tried before the interior points ended.
    tried: Vec<ContactMode>,
    iterate: Iterate,
    /// Impulse from which Newton's method starts.
    initial: Vec<f64>,
    /// The impulse with the least residual so far, and the modes of its contacts.
    best: Iterate,
    modes: Vec<ContactMode>,
    /// The selected contacts, and a solver for them and for problems of less friction.
    selected: Vec<usize>,
    part: Option<Box<Coulomb>>,
}

impl Coulomb {
    /// Solves the problem and writes the impulse [N·s]. The report has no residuals yet.
    pub fn solve(&mut self, problem: &Problem, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        self.cones.set(problem, Law::Cone);
        self.newton.set_problem(&self.cones);
        self.recall(problem, memory);
        self.begin();
        let solved = self.newton_from_memory(Limits::NORMAL)
            || self.friction_steps()
            || self.interior_points()
            || self.few_contacts()
            || self.patient_attempts(problem, memory)
            || self.least_squares()
            || self.energy_minima()
            || self.random_starts()
            || self.random_weights();
        self.cones.velocity(&self.best.f, &mut self.best.v);
        self.store(problem, memory);
        self.cones.unscale_impulse(problem, &self.best.f, impulse);
        let steps = self.iterate.steps;
        Report { pivots: steps, warm: solved && steps == 1, fallback: !solved, ..Report::default() }
    }

    /// Takes modes, slips and impulses of the last step from the memory as the initial guess.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        let Coulomb { cones, guess, initial, .. } = self;
        guess.modes.clear();
        guess.slips.clear();
        initial.clear();
        initial.resize(3 * problem.contacts, 0.0);
        for (i, &id) in problem.id.iter().enumerate() {
            let last = memory.contact(id);
            guess.modes.push(last.mode);
            guess.slips.push(last.slip.map(|slip| slip / cones.scale[i]));
            (0..1 + problem.tangents).for_each(|k| initial[3 * i + k] = last.impulse[k] * cones.scale[i]);
        }
    }

    /// Starts from the initial guess. No impulse is the best yet.
    fn begin(&mut self) {
        let Coulomb { guess, iterate, initial, best, modes, .. } = self;
        iterate.f.clone_from(initial);
        iterate.steps = 0;
        best.f.clone_from(initial);
        best.f.fill(0.0);
        best.error = f64::INFINITY;
        modes.clone_from(&guess.modes);
    }

    /// Newton's method from the memory, or from zero impulse if the memory is empty. If that fails near a solution, once more with balanced
    /// weights, from the best impulse that it has found.
    fn newton_from_memory(&mut self, limits: Limits) -> bool {
        let has_memory = self.guess.modes.iter().any(|mode| *mode != ContactMode::Open);
        if self.newton_from(has_memory, true, Weight::Mass, limits) {
            return true;
        }
        self.initial.clone_from(&self.best.f);
        self.best.error <= NEAR_SOLUTION && self.newton_from(false, true, Weight::Balanced, limits)
    }

    /// Interior points with the shift μ |v_F| as an unknown.
    fn interior_points(&mut self) -> bool {
        self.interior_then_newton(StepRule::AGGRESSIVE, Limits::NORMAL, false) || self.best.error <= PROMISED
    }

    /// Interior points with cautious steps, then Newton's method from the memory. Both may take more steps.
    fn patient_attempts(&mut self, problem: &Problem, memory: &Memory) -> bool {
        if self.interior_then_newton(StepRule::CAUTIOUS, Limits::STIFF, false) {
            return true;
        }
        let solved = [Limits::STIFF, Limits::PATIENT].into_iter().any(|limits| {
            self.recall(problem, memory);
            self.newton_from_memory(limits)
        });
        solved || self.best.error <= PROMISED
    }

    /// Least squares from the best impulse so far, with each weight.
    fn least_squares(&mut self) -> bool {
        WEIGHTS.into_iter().any(|weight| {
            self.iterate.f.clone_from(&self.best.f);
            self.least_squares_then_newton(weight)
        })
    }

    /// Energy minima with a held shift, until the shift equals μ |v_F|.
    fn energy_minima(&mut self) -> bool {
        self.shift.reset(self.cones.contacts);
        self.minima(FIRST_MINIMA)
    }

    /// Energy minima from the present shift.
    fn minima(&mut self, count: u32) -> bool {
        for _ in 0..count {
            if self.interior_then_newton(StepRule::AGGRESSIVE, Limits::NORMAL, true) {
                return true;
            }
            self.cones.velocity(&self.initial, &mut self.iterate.v);
            self.shift.update(&self.iterate.v);
        }
        self.best.error <= PROMISED
    }

    /// Least squares from random impulses, with random weights, and energy minima from random shifts, in turns. Feet that press against each
    /// other often have several solutions, and points where one of the two methods stays although they are no solution.
    fn random_starts(&mut self) -> bool {
        let mut random = Rng::with_seed(SEED);
        let starts = RANDOM_START_ROWS / self.iterate.f.len().max(1);
        (0..starts.clamp(MIN_RANDOM_STARTS, MAX_RANDOM_STARTS)).any(|_| {
            let weight = random_power(&mut random, WEIGHT_DECADES);
            let size = self.cones.size * libm::exp10(-START_DECADES * random.f64());
            self.iterate.f.iter_mut().for_each(|f| *f = size * (2.0 * random.f64() - 1.0));
            self.shift.randomize(&self.cones, &mut random);
            self.least_squares_then_newton(weight) || self.minima(RESTART_MINIMA)
        })
    }

    /// Newton's method from the best impulse so far, with random weights and compliances. Where a light body carries one that is 1e9 to 1e14 times
    /// as heavy, f or ρ v outweighs the other for most weights ρ, and a contact keeps a wrong mode. Which weight decides all modes, and which
    /// compliance A needs, differs from problem to problem.
    fn random_weights(&mut self) -> bool {
        let mut random = Rng::with_seed(SEED);
        (0..WEIGHTED_RUNS).any(|_| {
            let weight = Weight::Masses(random_power(&mut random, MASS_DECADES));
            let compliance = random_power(&mut random, COMPLIANCE_DECADES);
            self.initial.clone_from(&self.best.f);
            self.newton_from(false, true, weight, Limits::patient(compliance)) || self.best.error <= SOLVED
        })
    }

    /// Least squares from the present impulse, then Newton's method from the modes of its result.
    fn least_squares_then_newton(&mut self, weight: f64) -> bool {
        let Coulomb { cones, newton, guess, iterate, .. } = self;
        self.least_squares.run(cones, weight, iterate);
        natural_map::read_modes(cones, weight, iterate, guess);
        guess.join_patches(&newton.groups);
        self.initial.clone_from(&self.iterate.f);
        self.keep_best(true);
        self.newton_from(true, true, Weight::Balanced, Limits::NORMAL) || self.best.error <= SOLVED
    }

    /// Interior points. Whenever they indicate new modes, Newton's method tries these. At their end it starts from their result, with
    /// patches and then without.
    fn interior_then_newton(&mut self, rule: StepRule, limits: Limits, holds_shift: bool) -> bool {
        self.interior.start(&self.cones);
        self.tried.clear();
        loop {
            let held = holds_shift.then_some(&*self.shift.held);
            let ended = self.interior.advance(&self.cones, rule, held, &mut self.iterate);
            self.interior.guess(&self.cones, &mut self.guess);
            self.guess.join_patches(&self.newton.groups);
            self.initial.clone_from(&self.iterate.f);
            self.keep_best(true);
            if ended {
                let solved = self.newton_from(true, true, Weight::Balanced, limits) || self.best.error <= SOLVED;
                return solved || self.newton_from(false, false, Weight::Balanced, limits) || self.best.error <= SOLVED;
            }
            if self.tried != self.guess.modes {
                self.tried.clone_from(&self.guess.modes);
                if self.newton_from(true, true, Weight::Balanced, Limits::EARLY) {
                    return true;
                }
            }
        }
    }

    /// Newton's method from the initial impulse.
    fn newton_from(&mut self, uses_guess: bool, patches: bool, weight: Weight, limits: Limits) -> bool {
        self.iterate.f.clone_from(&self.initial);
        let guess = uses_guess.then_some(&self.guess);
        let solved = self.newton.run(&self.cones, Start { guess, patches, weight, limits }, &mut self.iterate);
        self.keep_best(!solved);
        if solved {
            self.modes.clear();
            self.modes.extend(self.newton.modes());
        }
        solved
    }

    /// Keeps the present impulse if its residual is the least so far. `evaluates`: whether the residual must be computed first.
    fn keep_best(&mut self, evaluates: bool) {
        let Coulomb { cones, guess, iterate, best, modes, .. } = self;
        if evaluates {
            cones.velocity(&iterate.f, &mut iterate.v);
            iterate.error = cones.residual(&iterate.f, &iterate.v);
        }
        if iterate.error < best.error {
            best.copy(iterate);
            modes.clone_from(&guess.modes);
        }
    }

    /// Stores modes, slips and impulses for the next step.
    fn store(&mut self, problem: &Problem, memory: &mut Memory) {
        let Coulomb { cones, modes, best, .. } = self;
        let mut is_static = true;
        memory.clear();
        for (i, &id) in problem.id.iter().enumerate() {
            let (f, v) = (contact_rows(&best.f, i), contact_rows(&best.v, i));
            let mode = if f[0] > 0.0 { modes[i] } else { ContactMode::Open };
            is_static &= f[0] <= 0.0 || v.iter().all(|v| v.abs() <= SOLVED * cones.speed(i));
            let slip = [v[1] * cones.scale[i], v[2] * cones.scale[i]];
            *memory.contact_mut(id) = LastContact { mode, slip, impulse: f.map(|f| f / cones.scale[i]), basis: 0 };
        }
        memory.is_static = is_static;
    }
}

/// A number between 10 to the power of `least` and of `greatest`, its logarithm uniform.
fn random_power(random: &mut Rng, [least, greatest]: [f64; 2]) -> f64 {
    libm::exp10(least + (greatest - least) * random.f64())
}
