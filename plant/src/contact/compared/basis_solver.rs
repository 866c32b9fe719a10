//! The laws whose solution is a basis. The attempts run from the cheapest to the most reliable; the residual alone decides.
//!
//! ```text
//!   solve(problem, memory):
//!     recall           the basis of the last step
//!     try_basis        solve with it as it is
//!     energy_stage     the energy program from that basis on; for Coulomb's law, follow the shift path    (energy_qp)
//!     lemke_stage      for Coulomb's law: Lemke's method with 32 digits, from that result                 (facets, lemke)
//!     restore_best     if all failed: the impulse with the least residual, with `fallback` set            (square_cone)
//! ```
//!
//! The basis determines the mode of every contact: open, sticking, or sliding on a certain facet. Its impulse is computed from A and b
//! (`basis_system`). The contacts are slightly compliant in all attempts ([`COMPLIANCE`], [`LEMKE_COMPLIANCE`]), so that there is one
//! solution. The residual does not include the compliance.

use super::super::memory::Memory;
use super::super::problem::Problem;
use super::super::report::Report;
use super::super::tolerance::{COMPLIANCE, LEMKE_COMPLIANCE, SOLVED};
use super::basis_system::BasisSystem;
use super::energy_qp::shift_path::ShiftPath;
use super::energy_qp::{EnergyQp, minimises_energy};
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
    /// Shift of each v_N in the energy program. At the solution of Coulomb's law it equals μ |v_F|.
    shift: ShiftPath,
    f: Vec<f64>,
    v: Vec<f64>,
    /// The impulse at which Lemke's method ended.
    lemke_impulse: Vec<f64>,
    /// The impulse with the least residual so far, and that residual.
    best: Vec<f64>,
    least: f64,
}

impl BasisSolver {
    /// Solves the problem and writes the impulse [N·s].
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
        report.fallback = report.breaks_promise();
        report.warm = found && self.is_as_before(problem, memory);
        self.unscale(impulse);
        self.store(problem, memory, impulse);
        report
    }

    /// Runs the attempts; false if all of them fail.
    fn find(&mut self, law: Law, pivots: &mut u32) -> bool {
        self.with_compliance(COMPLIANCE, |solver| solver.try_basis(law))
            || self.with_compliance(COMPLIANCE, |solver| solver.energy_stage(law, pivots))
            || !minimises_energy(law)
                && self.with_compliance(LEMKE_COMPLIANCE, |solver| solver.lemke_stage(law, pivots))
    }

    /// Loads the bases of the last step.
    fn recall(&mut self, problem: &Problem, memory: &Memory) {
        let d = self.scaled.facets();
        self.basis.clear();
        self.basis.extend(problem.id.iter().map(|&id| status::recall(memory.contact(id), d)));
    }

    fn is_as_before(&self, problem: &Problem, memory: &Memory) -> bool {
        let d = self.scaled.facets();
        problem.id.iter().zip(&self.basis).all(|(&id, &bits)| status::recall(memory.contact(id), d) == bits)
    }

    /// Stores bases and impulses for the next step.
    fn store(&self, problem: &Problem, memory: &mut Memory, impulse: &[f64]) {
        memory.store(problem, impulse);
        let (stride, least) = (self.scaled.stride(), SOLVED * square_cone::scale(&self.scaled, &self.f));
        let mut contacts = self.f.chunks_exact(stride).zip(self.v.chunks_exact(stride));
        memory.is_static = contacts.all(|(f, v)| f[0] == 0.0 || v.iter().all(|v| v.abs() <= least));
        problem.id.iter().zip(&self.basis).for_each(|(&id, &bits)| memory.contact_mut(id).basis = bits);
    }

    /// Runs an attempt with compliant contacts. If it fails, the contacts are rigid again.
    fn with_compliance(&mut self, compliance: f64, attempt: impl FnOnce(&mut BasisSolver) -> bool) -> bool {
        self.scaled.set_compliance(compliance);
        let found = attempt(self);
        if !found {
            self.scaled.set_compliance(0.0);
        }
        found
    }

    /// The residual of a given impulse in the conditions of the law itself.
    pub fn own_residual(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> f64 {
        self.scaled.set(problem, law);
        self.f.clear();
        self.f.extend(impulse.iter().zip(&self.scaled.root).map(|(f, r)| f * r));
        self.scaled.velocity(&self.f, &mut self.v);
        square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law))
    }

    /// Solves with the present basis; true if that meets the tolerance.
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

    /// Lemke's method with 32 digits. Its basis gives the impulse; where the basis is singular, the method's own impulse is taken.
    fn lemke_stage(&mut self, law: Law, pivots: &mut u32) -> bool {
        let BasisSolver { facets, scaled, basis, f, lemke_impulse, .. } = self;
        status::complement(scaled, f, basis);
        if !facets.solve_along_tangents(scaled, basis, lemke_impulse, pivots) {
            return false;
        }
        if self.try_basis(law) {
            return true;
        }
        self.f.clone_from(&self.lemke_impulse);
        self.update_velocity();
        let error = square_cone::natural_map(&self.scaled, &self.f, &self.v, optimality(law));
        self.keep_best(error);
        error <= SOLVED
    }

    /// Keeps the present impulse if its residual is the least so far.
    fn keep_best(&mut self, error: f64) {
        if error < self.least {
            self.least = error;
            self.best.clone_from(&self.f);
        }
    }

    /// Restores the impulse with the least residual so far.
    fn restore_best(&mut self) {
        self.f.clone_from(&self.best);
        self.update_velocity();
    }

    /// Computes the velocity of rigid contacts.
    fn update_velocity(&mut self) {
        self.scaled.velocity(&self.f, &mut self.v);
        self.scaled.remove_compliance(&self.f, &mut self.v);
    }

    /// Converts the impulse from sqrt(J) to N·s.
    fn unscale(&self, impulse: &mut Vec<f64>) {
        impulse.clear();
        impulse.extend(self.f.iter().zip(&self.scaled.root).map(|(f, &r)| if r > 0.0 { f / r } else { 0.0 }));
    }
}

/// The optimality conditions of a law.
pub(super) fn optimality(law: Law) -> Optimality {
    match law {
        Law::EnergyQp | Law::EnergyQpGap => Optimality::EnergyMinimum,
        _ => Optimality::Coulomb,
    }
}
