//! The laws whose solution is a basis: from the cheapest way to it to the surest, each judged by its residual alone.
//!
//! ```text
//!   solve(problem, memory):
//!     recall     the basis of the last step
//!     try        it as it is
//!     slide      the energy program from that basis on; for Coulomb's law the path to the shifted one   (energy_qp)
//!     pivot      for Coulomb's law: Lemke in 32 digits from what that guessed                           (facets, lemke)
//!     the impulse with the least residual of all, flagged                                               (diamond)
//! ```
//!
//! A basis says of every contact whether it is open, sticks, or slides which way; its impulse is computed afresh from A and b (`basis`).
//! Contacts yield by rounding on the way ([`COMPLIANCE`], [`LEMKE_COMPLIANCE`]), so that there is one solution; the residual is that of rigid ones.

use super::super::tolerance::{COMPLIANCE, LEMKE_COMPLIANCE, PROMISED, SOLVED};
use super::super::{Memory, Problem, Report};
use super::basis_system::BasisSystem;
use super::energy_qp::{EnergyQp, ShiftPath, minimises_energy};
use super::facets::Facets;
use super::scaled_problem::ScaledProblem;
use super::square_cone::{self, Optimality};
use super::status;
use messages::scene::Law;

mod energy_stage;
#[cfg(test)]
mod ill_conditioned;
mod reserve;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct BasisSolver {
    scaled: ScaledProblem,
    facets: Facets,
    energy_qp: EnergyQp,
    block: BasisSystem,
    basis: Vec<u8>,
    /// What is added to each v_N in the shifted energy program: mu |v_F| in the end.
    shift: ShiftPath,
    f: Vec<f64>,
    v: Vec<f64>,
    /// The impulse at which Lemke's method ended.
    lu: Vec<f64>,
    /// The impulse with the least residual so far, and that.
    best: Vec<f64>,
    least: f64,
}

impl BasisSolver {
    /// Solves; writes the impulse [N·s].
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory, impulse: &mut Vec<f64>) -> Report {
        self.scaled.set(problem, law);
        self.least = f64::INFINITY;
        self.best.clear();
        self.best.resize(self.scaled.drift.len(), 0.0);
        self.recall(problem, memory);
        let mut report = Report::default();
        let found = self.find(law, &mut report.pivots);
        if !found {
            self.restore_best();
        }
        report.own = square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law));
        report.fallback = !(found || report.own <= PROMISED);
        report.warm = found && self.is_as_before(problem, memory);
        self.unscale(impulse);
        self.store(problem, memory, impulse);
        report
    }

    /// Finds the solution; false if every way failed.
    fn find(&mut self, law: Law, pivots: &mut u32) -> bool {
        self.with_compliance(COMPLIANCE, |solver| solver.try_basis(law))
            || self.with_compliance(COMPLIANCE, |solver| solver.energy_stage(law, pivots))
            || !minimises_energy(law)
                && self.with_compliance(LEMKE_COMPLIANCE, |solver| solver.lemke_stage(law, pivots))
    }

    /// The bases of the last step.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        let d = self.scaled.facets();
        self.basis.clear();
        self.basis.extend(problem.id.iter().map(|&id| status::recall(memory.contact(id), d)));
    }

    fn is_as_before(&self, problem: &Problem, memory: &Memory) -> bool {
        let d = self.scaled.facets();
        problem.id.iter().zip(&self.basis).all(|(&id, &bits)| status::recall(memory.contact(id), d) == bits)
    }

    /// Keeps what the contacts did for the next step.
    fn store(&self, problem: &Problem, memory: &mut Memory, impulse: &[f64]) {
        memory.store(problem, impulse);
        let (stride, least) = (self.scaled.stride(), SOLVED * square_cone::scale(&self.scaled, &self.f));
        let mut contacts = self.f.chunks_exact(stride).zip(self.v.chunks_exact(stride));
        memory.is_static = contacts.all(|(f, v)| f[0] == 0.0 || v.iter().all(|v| v.abs() <= least));
        problem.id.iter().zip(&self.basis).for_each(|(&id, &bits)| memory.contact_mut(id).basis = bits);
    }

    /// Goes a way with contacts that yield by so much; they are rigid again if it finds nothing.
    fn with_compliance(&mut self, compliance: f64, solver: impl FnOnce(&mut BasisSolver) -> bool) -> bool {
        self.scaled.set_compliance(compliance);
        let found = solver(self);
        if !found {
            self.scaled.set_compliance(0.0);
        }
        found
    }

    /// The residual of a given impulse in the law's own problem.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        self.scaled.set(problem, law);
        self.f.clear();
        self.f.extend(impulse.iter().zip(&self.scaled.root).map(|(f, r)| f * r));
        self.scaled.velocity(&self.f, &mut self.v);
        square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law))
    }

    /// Whether the present basis is the solution.
    fn try_basis(&mut self, law: Law) -> bool {
        if !self.block.solve(&self.scaled, law, &self.basis, &mut self.f, &mut self.v) {
            return false;
        }
        if minimises_energy(law) {
            self.scaled.remove_compliance(&self.f, &mut self.v);
        }
        let error = square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law));
        self.keep_best(error);
        error <= SOLVED
    }

    /// Lemke's method in 32 digits, where it ends at a solution: that of its basis, or its own where that is singular.
    fn lemke_stage(&mut self, law: Law, pivots: &mut u32) -> bool {
        let BasisSolver { facets, scaled, basis, f, lu, .. } = self;
        status::complement(scaled, f, basis);
        if !facets.solve_along_tangents(scaled, basis, lu, pivots) {
            return false;
        }
        if self.try_basis(law) {
            return true;
        }
        self.f.clone_from(&self.lu);
        self.update_velocity();
        let error = square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law));
        self.keep_best(error);
        error <= SOLVED
    }

    /// Remembers the impulse if its residual is the least so far.
    fn keep_best(&mut self, error: f64) {
        if error < self.least {
            self.least = error;
            self.best.clone_from(&self.f);
        }
    }

    /// Goes back to the impulse with the least residual so far.
    fn restore_best(&mut self) {
        self.f.clone_from(&self.best);
        self.update_velocity();
    }

    /// The velocity of rigid contacts.
    fn update_velocity(&mut self) {
        self.scaled.velocity(&self.f, &mut self.v);
        self.scaled.remove_compliance(&self.f, &mut self.v);
    }

    /// From energy units back to N·s.
    fn unscale(&self, impulse: &mut Vec<f64>) {
        impulse.clear();
        impulse.extend(self.f.iter().zip(&self.scaled.root).map(|(f, &r)| if r > 0.0 { f / r } else { 0.0 }));
    }
}

/// Optimality that the law's own solution has.
pub(super) fn optimality(law: Law) -> Optimality {
    match law {
        Law::EnergyQp | Law::EnergyQpGap => Optimality::EnergyMinimum,
        _ => Optimality::Coulomb,
    }
}
