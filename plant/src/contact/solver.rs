//! The solver: from the cheapest way to a complementary basis to the surest, each judged by its residual alone.

mod fall_back;
#[cfg(test)]
mod hard;
mod rehearse;
mod slide;

use super::basis::Block;
use super::certificate::Judge;
use super::cones::Cones;
use super::coulomb::Coulomb;
use super::energy_qp::{EnergyQp, Shift, minimises_energy};
use super::facets::Facets;
use super::lemke::{Care, FINE};
use super::residual::{self, Yardstick};
use super::scaled::{self, HAIR, Scaled, YIELD};
use super::tolerance::SOLVED;
use super::{Memory, Problem, Report, has_basis, status};
use messages::scene::Law;

/// Contacts of one foot, the pressure under which is to be the evenest of those that are right.
pub(super) const FEW: usize = 4;
/// Contacts of two feet that stand: while they slide, the basis seldom lasts.
const BOTH: usize = 8;

/// Solver of contact problems: workspace and last solution. With [`Memory`] kept it may be dropped between steps without
/// changing results.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    /// Contact impulse f [N·s].
    pub impulse: Vec<f64>,
    /// Contact velocity v = A f + b [m/s].
    pub velocity: Vec<f64>,
    scaled: Scaled,
    coulomb: Coulomb,
    judge: Judge,
    cones: Cones,
    proximal: Scaled,
    facets: Facets,
    energy_qp: EnergyQp,
    block: Block,
    basis: Vec<u8>,
    /// What is added to each v_N in the shifted energy program: mu |v_F| in the end.
    shift: Shift,
    f: Vec<f64>,
    v: Vec<f64>,
    best: Vec<f64>,
    /// Residual of `best`.
    least: f64,
}

impl Solver {
    /// Solves the problem under the law and writes [`Solver::impulse`] and [`Solver::velocity`].
    ///
    /// Each way ends in a basis, and whatever way it came is accepted by its residual in the given problem alone:
    ///
    /// 1. the basis in `memory` as it is, of two feet that stand only if it may last;
    /// 2. the energy program from that basis on, with contacts that yield by rounding (`scaled::YIELD`), and for Coulomb's law the
    ///    path from its optimum to that of the shifted program;
    /// 3. for Coulomb's law, of many contacts Lemke's method; then the shifted program again, of contacts that yield by less
    ///    (`scaled::HAIR`);
    /// 4. Lemke's method in 32 digits from what that guessed. Contacts yield by a hair there: such a problem has a solution, and the
    ///    path ends at it;
    /// 5. flagged as a fallback: a regularised problem, and the impulse with the least residual of all.
    ///
    /// Nothing is allocated up to the size that was rehearsed or met before, but by some laws without a basis. Where the law has one
    /// velocity as its answer, v is the same warm or cold to the residual; f may differ by what A does not see. (The energy minimum
    /// always has one. Coulomb's law has several in jammed arrangements at high friction; then either is valid.)
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        if law == Law::Cone {
            let mut report = self.coulomb.solve(problem, memory, &mut self.impulse);
            self.find_velocity(problem);
            self.certify(problem, law, &mut report);
            report.own = report.natural_map;
            return report;
        }
        if !has_basis(law) {
            return self.solve_cones(problem, law, memory);
        }
        self.scaled.set(problem, law);
        self.least = f64::INFINITY;
        self.best.clear();
        self.best.resize(self.scaled.drift.len(), 0.0);
        self.recall(problem, memory);
        let mut report = Report::default();
        let solved = self.find(law, memory, &mut report);
        if !solved {
            report.fallback = true;
            report.pivots += self.fall_back(law);
        }
        report.warm = solved && problem.id.iter().zip(&self.basis).all(|(&id, &bits)| memory.recall(id) == bits);
        memory.note_pivots(report.pivots, report.warm || 4 * report.pivots as usize <= problem.contacts);
        problem.id.iter().zip(&self.basis).for_each(|(&id, &bits)| memory.remember(id, bits));
        memory.yields = self.scaled.yields();
        memory.rests = self.rests();
        self.unscale(problem);
        self.measure(problem, law, &mut report);
        report
    }

    /// Whether nothing that pushes moves.
    fn rests(&self) -> bool {
        let (stride, least) = (self.scaled.stride(), SOLVED * residual::scale(&self.scaled, &self.f));
        let mut contacts = self.f.chunks_exact(stride).zip(self.v.chunks_exact(stride));
        contacts.all(|(f, v)| f[0] == 0.0 || v.iter().all(|v| v.abs() <= least))
    }

    /// The bases of the last step.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        self.basis.clear();
        self.basis.extend(problem.id.iter().map(|&id| memory.recall(id)));
    }

    /// The laws without a basis: forces by formula, round cones, pyramids, iterations.
    fn solve_cones(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        let mut report = self.cones.solve(problem, law, memory, &mut self.impulse);
        self.find_velocity(problem);
        self.certify(problem, law, &mut report);
        report
    }

    /// Finds the solution, the way that most steps take first; false if every way failed.
    fn find(&mut self, law: Law, memory: &Memory, report: &mut Report) -> bool {
        let (pivots, count) = (&mut report.pivots, self.scaled.contacts);
        let many = count > BOTH;
        (count != BOTH || memory.may_last()) && self.holds(law, memory.yields)
            || self.while_yielding(YIELD, |solver| solver.slide(law, pivots))
            // of many contacts most are redundant, and its path visits few of them
            || !minimises_energy(law) && (many && self.pivot(law, FINE, pivots)
                || self.while_yielding(HAIR, |solver| solver.slide(law, pivots)) // where they slip no faster than they yield
                || self.while_yielding(HAIR, |solver| solver.pivot_exactly(law, pivots)))
    }

    /// Goes a way with contacts that yield by so much; they are rigid again if it finds nothing.
    fn while_yielding(&mut self, give: f64, way: impl FnOnce(&mut Solver) -> bool) -> bool {
        self.scaled.give(give);
        let found = way(self);
        if !found {
            self.scaled.give(0.0);
        }
        found
    }

    /// Residuals of a given impulse, as a yardstick for any other solver.
    pub fn measure_impulse(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> Report {
        if !has_basis(law) {
            let mut report = self.cones.measure(problem, law, impulse);
            self.impulse.clear();
            self.impulse.extend_from_slice(impulse);
            self.find_velocity(problem);
            self.certify(problem, law, &mut report);
            if law == Law::Cone {
                report.own = report.natural_map;
            }
            return report;
        }
        self.scaled.set(problem, law);
        self.f.clear();
        self.f.extend(impulse.iter().zip(&self.scaled.root).map(|(f, r)| f * r));
        self.scaled.velocity(&self.f, &mut self.v);
        self.unscale(problem);
        let mut report = Report::default();
        self.measure(problem, law, &mut report);
        report
    }

    /// Impulse and velocity of the basis; its residual, infinite when the basis is singular.
    fn try_basis(&mut self, law: Law) -> f64 {
        if !self.block.solve(&self.scaled, law, &self.basis, &mut self.f, &mut self.v) {
            return f64::INFINITY;
        }
        if minimises_energy(law) {
            self.scaled.harden(&self.f, &mut self.v);
        }
        residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law))
    }

    /// Whether the basis in memory is the solution, of contacts that yield or do not.
    fn holds(&mut self, law: Law, yields: bool) -> bool {
        if yields {
            self.scaled.give(YIELD);
        }
        let holds = self.is_solved(law);
        if yields && !holds {
            self.scaled.give(0.0);
        }
        holds
    }

    /// Whether the present basis is the solution.
    fn is_solved(&mut self, law: Law) -> bool {
        self.try_basis(law) <= SOLVED
    }

    /// Lemke's pivoting on the complementarity problem.
    fn pivot(&mut self, law: Law, care: Care, pivots: &mut u32) -> bool {
        self.facets.pivot(&self.scaled, care, &mut self.basis, pivots) && self.is_solved(law)
    }

    /// The same in 32 digits, where it ends at a solution: that of its basis, or its own where that is singular.
    fn pivot_exactly(&mut self, law: Law, pivots: &mut u32) -> bool {
        let Solver { facets, scaled, basis, f, best, .. } = self;
        status::complement(scaled, f, basis);
        if !facets.pivot_exactly(scaled, basis, best, pivots) {
            return false;
        }
        if self.is_solved(law) {
            return true;
        }
        self.take_best();
        let error = residual::natural_map(&self.scaled, &self.f, &self.v, yardstick(law));
        self.note(error);
        error <= SOLVED
    }

    /// From energy units back to N·s and m/s.
    fn unscale(&mut self, problem: &Problem) {
        self.impulse.clear();
        self.impulse.extend(self.f.iter().zip(&self.scaled.root).map(|(f, &r)| if r > 0.0 { f / r } else { 0.0 }));
        self.find_velocity(problem);
    }

    /// v = A f + b of the present impulse.
    fn find_velocity(&mut self, problem: &Problem) {
        scaled::respond(&problem.delassus, &problem.drift, &self.impulse, &mut self.velocity);
    }

    fn measure(&mut self, problem: &Problem, law: Law, report: &mut Report) {
        let Solver { scaled, f, v, .. } = &*self;
        report.own = residual::natural_map(scaled, f, v, yardstick(law));
        self.certify(problem, law, report);
    }

    /// The residuals of Coulomb's law with the round cone, and the energy.
    fn certify(&mut self, problem: &Problem, law: Law, report: &mut Report) {
        let residual = self.judge.judge(problem, law, &self.impulse, &self.velocity);
        report.natural_map = residual.natural_map;
        report.signorini = residual.signorini;
        report.slip_misalignment = residual.misalignment;
        (report.energy_gain, report.work) = self.energy(problem);
    }

    /// f·v - f·A f/2 with A f = v - b, and what that is to be seen beside: the work of the impulses, and the energy of motion that the
    /// contacts could take \[J\].
    fn energy(&self, problem: &Problem) -> (f64, f64) {
        let rows = self.impulse.iter().zip(self.velocity.iter().zip(&problem.drift));
        let diagonal = problem.delassus.iter().step_by(problem.rows() + 1);
        rows.zip(diagonal).fold((0.0, 0.0), |(gain, work), ((f, (v, b)), a)| {
            let motion = if *a > 0.0 { b * b / a } else { 0.0 };
            (gain + 0.5 * f * (v + b), work + 0.5 * ((f * v).abs() + (f * b).abs() + motion))
        })
    }
}

/// Optimality that the law's own solution has.
fn yardstick(law: Law) -> Yardstick {
    match law {
        Law::EnergyQp | Law::EnergyQpGap => Yardstick::EnergyMinimum,
        _ => Yardstick::Coulomb,
    }
}
