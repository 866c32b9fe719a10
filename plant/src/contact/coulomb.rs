//! Coulomb's law with the round cone, (17)-(22): the law `Cone`.
//!
//! ```text
//!   solve(problem, memory):
//!     recall     what each contact did in the last step, its impulse and its slip
//!     Newton     from there; patches that do not hold are freed, and Newton again         (newton, patch)
//!     interior   points, fast and slowly, each with Newton from where they end            (interior)
//!     minima     of the energy with De Saxcé's shift held, each with Newton, until the
//!                shift is that of the slip                                                (shift)
//!     keep       of all impulses that with the least residual, and what its contacts do   (certificate)
//! ```
//!
//! Each rung leaves its impulse; the next is taken where none meets the certificate yet: the natural map of the round cone in the problem
//! as it was posed. What the last leaves unsolved is flagged. Before all of them the step tries feet that stand, for which nobody needs A:
//! [`crate::weld`].
//!
//! Coulomb's law has several answers in places. Among impulses with the same effect that of least norm over each link is taken, spread as
//! [`patch`] says; among different motions the first that is found, from what the contacts did in the step before. So it is in every method.

mod interior;
mod newton;
mod patch;
#[cfg(test)]
mod rungs;
mod shift;

use super::memory::{Contact, Memory};
use super::round::{Round, part};
use super::tolerance::{PROMISED, SOLVED};
use super::{Problem, Report};
use interior::{Interior, Pace};
use messages::scene::Law;
use newton::Newton;
use shift::Shift;

/// Choices of patches that are tried: all that there may be, then without those that stuck.
const CHOICES: usize = 2;
/// Energy minima at most. Half of the problems that need them need one, one in ten more than ten.
const MINIMA: u32 = 50;

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
    shift: Shift,
    start: Start,
    iterate: Iterate,
    /// The impulse that Newton's method begins at.
    begin: Vec<f64>,
    /// The impulse with the least residual so far, and what its contacts do.
    best: Iterate,
    kinds: Vec<Kind>,
}

impl Coulomb {
    /// Solves; writes the impulse [N·s]. The report has no residuals yet.
    pub fn solve(&mut self, problem: &Problem, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        self.round.set(problem, Law::Cone);
        self.newton.begin(&self.round);
        self.recall(problem, memory);
        let solved = self.near() || self.through_interior() || self.through_minima();
        self.round.velocity(&self.best.f, &mut self.best.v);
        self.keep(problem, memory);
        self.round.write(problem, &self.best.f, impulse);
        let steps = self.iterate.steps;
        Report { pivots: steps, warm: solved && steps == 1, fallback: !solved, ..Report::default() }
    }

    /// What the contacts did in the last step.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        let Coulomb { round, start, iterate, begin, best, kinds, .. } = self;
        start.kinds.clear();
        start.slips.clear();
        begin.clear();
        begin.resize(3 * problem.contacts, 0.0);
        for (i, &id) in problem.id.iter().enumerate() {
            let last = memory.contact(id);
            start.kinds.push(last.kind);
            start.slips.push(last.slip.map(|slip| slip / round.scale[i]));
            (0..1 + problem.tangents).for_each(|k| begin[3 * i + k] = last.impulse[k] * round.scale[i]);
        }
        iterate.f.clone_from(begin);
        iterate.steps = 0;
        best.f.clone_from(begin);
        best.f.fill(0.0);
        best.error = f64::INFINITY;
        kinds.clone_from(&start.kinds);
    }

    /// Newton's method from what the contacts did, or from no impulse: with all patches that there may be, then without those that stuck and
    /// did not hold.
    fn near(&mut self) -> bool {
        let recalls = self.begin.iter().any(|f| *f != 0.0);
        let mut free = 0;
        for _ in 0..CHOICES {
            if self.newton_from(recalls, free) {
                return true;
            }
            let sticking = self.newton.groups.iter().enumerate().filter(|(_, group)| group.sticks);
            let next = sticking.fold(free, |bits, (g, _)| bits | 1 << g.min(31));
            if next == free {
                return false;
            }
            free = next;
        }
        false
    }

    /// Interior points with |v_F| as it becomes.
    fn through_interior(&mut self) -> bool {
        [Pace::FAST, Pace::SLOW].into_iter().any(|pace| self.at_pace(pace, false)) || self.best.error <= PROMISED
    }

    /// Energy minima with |v_F| held, until it is that of the slip.
    fn through_minima(&mut self) -> bool {
        self.shift.begin(self.round.contacts);
        for _ in 0..MINIMA {
            if self.at_pace(Pace::FAST, true) {
                return true;
            }
            self.round.velocity(&self.begin, &mut self.iterate.v);
            self.shift.follow(&self.iterate.v);
        }
        self.best.error <= PROMISED
    }

    /// Interior points, then Newton's method from what the contacts do there, with patches and without.
    fn at_pace(&mut self, pace: Pace, holds: bool) -> bool {
        let held = holds.then_some(&*self.shift.held);
        self.interior.run(&self.round, pace, held, &mut self.iterate);
        let groups = self.newton.groups.iter().map(|group| (group.first, group.end));
        self.interior.start(&self.round, groups, &mut self.start);
        self.begin.clone_from(&self.iterate.f);
        self.note(true);
        self.newton_from(true, 0) || self.newton_from(false, u32::MAX) || self.best.error <= SOLVED
    }

    /// Newton's method from the beginning; the groups of `free` do not stick as a patch.
    fn newton_from(&mut self, knows: bool, free: u32) -> bool {
        self.iterate.f.clone_from(&self.begin);
        let start = knows.then_some(&self.start);
        let solved = self.newton.run(&self.round, free, start, &mut self.iterate);
        self.note(!solved);
        if solved {
            self.kinds.clear();
            self.kinds.extend(self.newton.kinds());
        }
        solved
    }

    /// Remembers the impulse if its residual, which may have to be found yet, is the least so far.
    fn note(&mut self, finds: bool) {
        let Coulomb { round, start, iterate, best, kinds, .. } = self;
        if finds {
            round.velocity(&iterate.f, &mut iterate.v);
            iterate.error = round.residual(&iterate.f, &iterate.v);
        }
        if iterate.error < best.error {
            best.copy(iterate);
            kinds.clone_from(&start.kinds);
        }
    }

    /// Keeps what the contacts did for the next step.
    fn keep(&mut self, problem: &Problem, memory: &mut Memory) {
        let Coulomb { round, kinds, best, .. } = self;
        let mut rests = true;
        memory.forget();
        for (i, &id) in problem.id.iter().enumerate() {
            let (f, v) = (part(&best.f, i), part(&best.v, i));
            let kind = if f[0] > 0.0 { kinds[i] } else { Kind::Open };
            rests &= f[0] <= 0.0 || v.iter().all(|v| v.abs() <= SOLVED * round.speed(i));
            let slip = [v[1] * round.scale[i], v[2] * round.scale[i]];
            *memory.contact_mut(id) = Contact { kind, slip, impulse: f.map(|f| f / round.scale[i]), basis: 0 };
        }
        memory.rests = rests;
    }
}

impl Iterate {
    /// Becomes the other impulse, in the room it has; it counts its own systems.
    fn copy(&mut self, other: &Iterate) {
        self.f.clone_from(&other.f);
        self.v.clone_from(&other.v);
        self.error = other.error;
    }
}
