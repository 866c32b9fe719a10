//! Laws of round cones and pyramids, from the cheapest start to the surest.

use super::super::round::Round;
use super::super::tolerance::SOLVED;
use super::super::{Memory, Problem, Report};
use super::cone_qp::ConeQp;
use super::facets::Facets;
use super::fixed_point;
use super::newton::Newton;
use super::rule::{Rule, natural_map};
use super::scaled::{HAIR, Scaled};
use super::spring_damper;
use super::sweep::sweep;
use messages::scene::{Iteration, Law};

/// Sweeps before each new start of Newton's method.
const BURSTS: [u32; 4] = [3, 12, 50, 200];

/// Workspace and last solution of the laws that have no basis along the problem's tangents.
#[derive(Clone, Debug, Default)]
pub(super) struct Cones {
    round: Round,
    f: Vec<f64>,
    v: Vec<f64>,
    newton: Newton,
    cone_qp: ConeQp,
    facets: Facets,
    scaled: Scaled,
    swept: Vec<f64>,
    best: Vec<f64>,
    /// Friction bound or shift of v_N that the present iterate is solved with.
    pub held: Vec<f64>,
    /// How far the last minimum was from what it was made with.
    change: Vec<f64>,
}

impl Cones {
    /// Solves; writes the impulse [N·s].
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        let mut report = Report::default();
        self.round.set(problem, law);
        impulse.clear();
        problem
            .id
            .iter()
            .for_each(|&id| impulse.extend_from_slice(&memory.contact(id).impulse[..1 + problem.tangents]));
        self.round.read(impulse, &mut self.f);
        let solved = match law {
            Law::SpringDamper => {
                spring_damper::push(problem, impulse);
                self.round.read(impulse, &mut self.f);
                true
            }
            Law::Sweep(count) => {
                (0..count).for_each(|_| sweep(&self.round, Rule::Coulomb, &mut self.f));
                report.pivots = count.into();
                true
            }
            Law::Lagged => {
                self.held.clear();
                self.hold(Iteration::Tresca, 1.0);
                self.with_held(|cones, held| cones.minimise(Rule::Bound(held), &mut report.pivots))
            }
            Law::ConeQp => {
                let energy = Rule::Energy(&[]);
                self.certify(energy, &mut report.pivots) || self.minimise(energy, &mut report.pivots)
            }
            Law::FixedPoint(iteration) => fixed_point::iterate(self, iteration, &mut report.pivots),
            _ => self.polygon(rule(law), &mut report.pivots),
        };
        report.fallback = !solved;
        self.round.velocity(&self.f, &mut self.v);
        report.own = match law {
            Law::SpringDamper => 0.0 * self.round.reach(&self.f), // a formula has no residual but NaN
            Law::Lagged => natural_map(&self.round, Rule::Bound(&self.held), &self.f, &self.v),
            _ => natural_map(&self.round, rule(law), &self.f, &self.v),
        };
        report.warm = solved && report.pivots == 0;
        self.round.write(problem, &self.f, impulse);
        memory.keep(problem, impulse);
        report
    }

    /// The residual of a given impulse in the law's own problem.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        self.round.set(problem, law);
        self.round.read(impulse, &mut self.f);
        self.residual(rule(law))
    }

    /// Takes this share of the bound, or of the shift, that the present impulse gives, the rest from before. Whether it changes that way
    /// as it did the last time, and not back.
    pub fn hold(&mut self, iteration: Iteration, share: f64) -> bool {
        let first = self.held.is_empty();
        if first {
            self.change.clear();
        }
        let Cones { round, f, v, held, change, .. } = self;
        held.resize(round.contacts, 0.0);
        change.resize(round.contacts, 0.0);
        let (at_rest, mut along) = (f.iter().all(|f| *f == 0.0), 0.0);
        for (i, (held, last)) in held.iter_mut().zip(change).enumerate() {
            let mu = round.friction[i];
            let new = match iteration {
                Iteration::Tresca => mu * f[3 * i].max(0.0),
                Iteration::Aclm if at_rest => 0.0,
                Iteration::Aclm => mu * v[3 * i + 1].hypot(v[3 * i + 2]),
            };
            let rise = new - *held;
            let next = if first { new } else { *held + share * rise };
            *held = if next < 0.0 { 0.0 } else { next }; // what is no number stays so
            along += rise * *last;
            *last = rise;
        }
        along > 0.0
    }

    /// Lends `held` to a rule.
    pub fn with_held<T>(&mut self, work: impl FnOnce(&mut Cones, &[f64]) -> T) -> T {
        let held = std::mem::take(&mut self.held);
        let result = work(self, &held);
        self.held = held;
        result
    }

    /// Coulomb's law with a polygon from the remembered impulse and from sweeps, then by Lemke's method in 32 digits, of contacts that yield by
    /// a hair.
    fn polygon(&mut self, rule: Rule<'_>, steps: &mut u32) -> bool {
        if self.settle(rule, steps) {
            return true;
        }
        let Rule::Polygon(d) = rule else { return false };
        let (least, kept) = (self.residual(rule), self.f.clone());
        let Cones { round, scaled, facets, newton, f, v, .. } = self;
        scaled.set_alike(round);
        scaled.give(HAIR);
        facets.around(scaled, d, f, steps);
        let error = newton.polish(round, rule, f, v, steps);
        if error.is_nan() || error > least {
            self.f = kept;
        }
        error <= SOLVED
    }

    /// Minimum of a convex rule: Newton's method, and behind it the interior-point method.
    pub fn minimise(&mut self, rule: Rule<'_>, steps: &mut u32) -> bool {
        if self.settle(rule, steps) || self.certify(rule, steps) {
            return true;
        }
        let (error, kept) = (self.residual(rule), self.f.clone());
        self.f.fill(0.0);
        if !self.settle(rule, steps) && self.residual(rule) > error {
            self.f = kept;
        }
        self.residual(rule) <= SOLVED
    }

    /// The interior-point method, and the last digits by Newton's.
    fn certify(&mut self, rule: Rule<'_>, steps: &mut u32) -> bool {
        *steps += self.cone_qp.solve(&self.round, rule, &mut self.f);
        self.newton.polish(&self.round, rule, &mut self.f, &mut self.v, steps) <= SOLVED
    }

    /// Newton's method from `f`, then from ever more sweeps; leaves the best.
    fn settle(&mut self, rule: Rule<'_>, steps: &mut u32) -> bool {
        self.swept.clone_from(&self.f);
        let mut least = self.newton.polish(&self.round, rule, &mut self.f, &mut self.v, steps);
        if least <= SOLVED || !self.round.size.is_finite() {
            return least <= SOLVED;
        }
        for count in BURSTS {
            (0..count).for_each(|_| sweep(&self.round, rule, &mut self.swept));
            self.best.clone_from(&self.f);
            self.f.clone_from(&self.swept);
            let error = self.newton.polish(&self.round, rule, &mut self.f, &mut self.v, steps);
            if error <= SOLVED {
                return true;
            }
            if error < least {
                least = error;
            } else {
                self.f.clone_from(&self.best);
            }
        }
        false
    }

    /// Natural map of the present impulse.
    pub fn residual(&mut self, rule: Rule<'_>) -> f64 {
        self.round.velocity(&self.f, &mut self.v);
        natural_map(&self.round, rule, &self.f, &self.v)
    }
}

/// The rule that a law's own residual is measured by.
pub(super) fn rule(law: Law) -> Rule<'static> {
    match law {
        Law::ConeQp => Rule::Energy(&[]),
        Law::Facets(d) => Rule::Polygon(d.into()),
        _ => Rule::Coulomb,
    }
}
