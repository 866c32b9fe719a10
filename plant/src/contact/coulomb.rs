//! Coulomb's law with the round cone, (17)-(22): the law `Cone`.
//!
//! ```text
//!   solve(problem, memory):
//!     recall     what each contact did in the last step, its impulse and its slip
//!     Newton     from there; patches that do not hold are freed, and Newton again         (newton, patch)
//!     interior   points, then Newton from what the contacts do where they end             (interior)
//!     follow     the solution while the compliance falls to ε
//!     the impulse with the least residual of all, flagged                                 (residual)
//! ```
//!
//! The first that meets the certificate is the solution: all are judged alike, by the natural map of the round cone in the problem as it
//! was posed. Before all of them the step tries feet that stand, for which nobody needs A: [`crate::weld`].
//!
//! Coulomb's law has several answers in places. Among impulses with the same effect that of least norm over each link is taken, spread as
//! [`patch`] says; among different motions the first that is found, from what the contacts did in the step before. So it is in every method.

mod interior;
mod newton;
mod patch;
mod residual;

use super::memory::Memory;
use super::round::{Round, part};
use super::tolerance::COMPLIANCE;
use super::{Problem, Report};
use interior::{Interior, Pace};
use messages::scene::Law;
use newton::{Newton, STEPS};
pub(super) use residual::{Judge, Scales, greater, speeds};

/// Choices of patches that are tried: all that there may be, then without those that stuck.
const CHOICES: usize = 2;
/// Compliance at which contacts hardly feel each other, as a power of ten; continuation begins there.
const SOFT: f64 = 2.0;
/// Solutions of the continuation at most.
const SOLUTIONS: u32 = 60;
/// Steps of Newton's method for each of these but the last.
const FEW: u32 = 6;
/// Shortest and longest step of the continuation, as powers of ten.
const STRIDES: [f64; 2] = [1e-3, 4.0];
/// What is left of a step that Newton's method does not bear [-].
const SHORTER: f64 = 0.4;

/// What a contact does.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Kind {
    /// It does not push.
    #[default]
    Open,
    /// It pushes and does not move, alone.
    Sticks,
    /// It pushes and does not move, nor do others of its link.
    Patch,
    /// It pushes and slips.
    Slides,
}

/// What contacts did somewhere: kinds, and velocities of slip in scaled units.
#[derive(Clone, Debug, Default)]
struct Start {
    kinds: Vec<Kind>,
    slips: Vec<[f64; 2]>,
}

/// An impulse, its velocity and its residual, scaled; and the linear systems solved so far.
#[derive(Clone, Debug, Default)]
struct Iterate {
    f: Vec<f64>,
    v: Vec<f64>,
    error: f64,
    steps: u32,
}

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Coulomb {
    round: Round,
    newton: Newton,
    interior: Interior,
    start: Start,
    iterate: Iterate,
    /// The impulse of the step before, and the one with the least residual so far.
    before: Vec<f64>,
    best: Vec<f64>,
    least: f64,
}

impl Coulomb {
    /// Solves; writes the impulse [N·s]. The report has no residuals yet.
    pub fn solve(&mut self, problem: &Problem, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        self.round.set(problem, Law::Cone);
        self.newton.begin(&self.round);
        self.recall(problem, memory);
        let recalls = self.before.iter().any(|f| *f != 0.0);
        let solved = self.near(recalls) || self.through_interior() || self.through_compliance();
        if !solved {
            self.iterate.f.clone_from(&self.best);
        }
        self.round.velocity(&self.iterate.f, &mut self.iterate.v);
        self.keep(problem, memory);
        self.round.write(problem, &self.iterate.f, impulse);
        Report {
            pivots: self.iterate.steps,
            warm: solved && self.iterate.steps == 1,
            fallback: !solved,
            ..Report::default()
        }
    }

    /// What the contacts did in the last step.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        let Coulomb { round, start, iterate, before, best, least, .. } = self;
        start.kinds.clear();
        start.slips.clear();
        before.clear();
        before.resize(3 * problem.contacts, 0.0);
        for (i, &id) in problem.id.iter().enumerate() {
            let last = memory.contact(id);
            start.kinds.push(last.kind);
            start.slips.push(last.slip.map(|slip| slip / round.scale[i]));
            (0..1 + problem.tangents).for_each(|k| before[3 * i + k] = last.impulse[k] * round.scale[i]);
        }
        *iterate =
            Iterate { f: std::mem::take(&mut iterate.f), v: std::mem::take(&mut iterate.v), ..Iterate::default() };
        iterate.f.clone_from(before);
        best.clone_from(before);
        best.fill(0.0);
        *least = f64::INFINITY;
    }

    /// Newton's method from what the contacts did, or from no impulse: with all patches that there may be, then without those that stuck and
    /// did not hold.
    fn near(&mut self, recalls: bool) -> bool {
        let mut free = 0;
        for _ in 0..CHOICES {
            self.iterate.f.clone_from(&self.before);
            let start = recalls.then_some(&self.start);
            if self.newton.run(&self.round, COMPLIANCE, free, start, STEPS, &mut self.iterate) {
                self.take_kinds();
                return true;
            }
            self.note();
            let sticking = self.newton.groups.iter().enumerate().filter(|(_, group)| group.sticks);
            let next = sticking.fold(free, |bits, (g, _)| bits | 1 << g.min(31));
            if next == free {
                return false;
            }
            free = next;
        }
        false
    }

    /// Interior points, then Newton's method from what the contacts do there, with patches and without.
    fn through_interior(&mut self) -> bool {
        Interior::takes(&self.round) && Pace::BOTH.into_iter().any(|pace| self.at_pace(pace))
    }

    fn at_pace(&mut self, pace: Pace) -> bool {
        let arrived = self.interior.run(&self.round, pace, &mut self.iterate);
        let groups = self.newton.groups.iter().map(|group| (group.first, group.end));
        self.interior.start(&self.round, groups, &mut self.start);
        self.note();
        self.before.clone_from(&self.iterate.f);
        for free in [0, u32::MAX] {
            self.iterate.f.clone_from(&self.before);
            let start = (free == 0).then_some(&self.start);
            if self.newton.run(&self.round, COMPLIANCE, free, start, STEPS, &mut self.iterate) {
                self.take_kinds();
                return true;
            }
            self.note();
        }
        self.iterate.f.clone_from(&self.before);
        arrived
    }

    /// Follows the solution from contacts so compliant that each has its own to those of the problem, in steps as long as Newton's method
    /// bears.
    fn through_compliance(&mut self) -> bool {
        self.round.each_by_itself(10f64.powf(SOFT), &mut self.iterate.f);
        self.before.clone_from(&self.iterate.f);
        let (mut at, mut stride, goal) = (SOFT, STRIDES[1], COMPLIANCE.log10());
        for _ in 0..SOLUTIONS {
            let next = f64::max(at - stride, goal);
            let last = next == goal;
            let (compliance, most) = if last { (COMPLIANCE, STEPS) } else { (10f64.powf(next), FEW) };
            if self.newton.run(&self.round, compliance, u32::MAX, None, most, &mut self.iterate) {
                if last {
                    self.take_kinds();
                    return true;
                }
                (at, stride) = (next, f64::min(2.0 * stride, STRIDES[1]));
                self.before.clone_from(&self.iterate.f);
                continue;
            }
            if last {
                self.note();
            }
            stride *= SHORTER;
            self.iterate.f.clone_from(&self.before);
            if stride < STRIDES[0] {
                break;
            }
        }
        false
    }

    /// The kinds that Newton's method ended with.
    fn take_kinds(&mut self) {
        self.start.kinds.clear();
        self.start.kinds.extend(self.newton.kinds());
    }

    /// Remembers the impulse if its residual is the least so far.
    fn note(&mut self) {
        let Iterate { f, v, error, .. } = &mut self.iterate;
        self.round.velocity(f, v);
        *error = self.round.residual(f, v, 0.0);
        if *error < self.least {
            self.least = *error;
            self.best.clone_from(f);
        }
    }

    /// Keeps what the contacts did for the next step.
    fn keep(&mut self, problem: &Problem, memory: &mut Memory) {
        let Coulomb { round, start, iterate, .. } = self;
        let mut rests = true;
        memory.forget_contacts();
        for (i, &id) in problem.id.iter().enumerate() {
            let (f, v) = (part(&iterate.f, i), part(&iterate.v, i));
            let kind = if f[0] > 0.0 { start.kinds[i] } else { Kind::Open };
            rests &= f[0] <= 0.0 || v.iter().all(|v| v.abs() <= 2.0 * COMPLIANCE * round.speed(i));
            memory.remember(id, super::status::standing(kind != Kind::Open, 4));
            let last = memory.contact_mut(id);
            last.kind = kind;
            last.slip = [v[1] * round.scale[i], v[2] * round.scale[i]];
            last.impulse = f.map(|f| f / round.scale[i]);
        }
        memory.rests = rests;
    }
}
