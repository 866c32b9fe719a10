//! The solver: it dispatches to the law's method and certifies the result.

use super::certificate::Evaluator;
use super::compared::Compared;
use super::coulomb::Coulomb;
use super::memory::Memory;
use super::problem::Problem;
use super::report::Report;
use super::round_cones::apply_delassus;
use messages::scene::Law;

/// Solver of contact problems: workspace and last solution. It holds no state: with [`Memory`] kept, a new solver gives the same results.
#[derive(Clone, Debug, Default)]
pub struct Solver {
    /// Contact impulse f [N·s].
    pub impulse: Vec<f64>,
    /// Contact velocity v = A f + b [m/s].
    pub velocity: Vec<f64>,
    coulomb: Coulomb,
    compared: Compared,
    evaluator: Evaluator,
}

impl Solver {
    /// Solves the problem under the law and writes [`Solver::impulse`] and [`Solver::velocity`].
    ///
    /// It does not allocate for sizes that were reserved or met before; some laws without a basis do. If the law determines one velocity, v
    /// is the same from any memory, up to the residual; f may differ within the null space of A. The energy minimum always determines v.
    /// Coulomb's law does not in jammed arrangements at high friction; then any solution is valid.
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        let report = match law {
            Law::Cone => self.coulomb.solve(problem, memory, &mut self.impulse),
            _ => self.compared.solve(problem, law, memory, &mut self.impulse),
        };
        self.certify(problem, law, report)
    }

    /// Residuals of a given impulse, for the comparison of other solvers.
    pub fn measure_impulse(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> Report {
        self.impulse.clear();
        self.impulse.extend_from_slice(impulse);
        let own = match law {
            Law::Cone => 0.0,
            _ => self.compared.own_residual(problem, law, impulse),
        };
        self.certify(problem, law, Report { own, ..Report::default() })
    }

    /// Allocates all memory before the first step, so that no step allocates.
    pub(crate) fn reserve_for(&mut self, contacts: usize, tangents: usize, law: Law) {
        match law {
            Law::Cone => self.coulomb.reserve_for(contacts, tangents),
            _ => self.compared.reserve_for(contacts, tangents, law),
        }
        let mut problem = Problem::default();
        problem.reset(contacts, tangents);
        let zeros = problem.drift.clone();
        self.measure_impulse(&problem, law, &zeros);
    }

    /// Computes the velocity, the residuals of Coulomb's law with the round cone, and the energy gain.
    fn certify(&mut self, problem: &Problem, law: Law, report: Report) -> Report {
        apply_delassus(&problem.delassus, &problem.drift, &self.impulse, &mut self.velocity);
        let residual = self.evaluator.evaluate(problem, law, &self.impulse, &self.velocity);
        let (energy_gain, work) = self.energy(problem);
        let report = Report {
            natural_map: residual.natural_map,
            own: match law {
                Law::Cone => residual.natural_map,
                _ if residual.enters => report.own.max(residual.signorini), // times a great friction its own scale may hide that
                _ => report.own,
            },
            fallback: report.fallback || residual.enters,
            signorini: residual.signorini,
            slip_misalignment: residual.misalignment,
            energy_gain,
            work,
            ..report
        };
        Report { fallback: report.fallback || law == Law::Cone && report.breaks_promise(), ..report }
    }

    /// Energy gain f·v - f·A f/2 with A f = v - b, and its scale: the work of the impulses, and the kinetic energy that the contacts could
    /// take \[J\].
    fn energy(&self, problem: &Problem) -> (f64, f64) {
        let rows = self.impulse.iter().zip(self.velocity.iter().zip(&problem.drift));
        let diagonal = problem.delassus.iter().step_by(problem.rows() + 1);
        rows.zip(diagonal).fold((0.0, 0.0), |(gain, work), ((f, (v, b)), a)| {
            let motion = if *a > 0.0 { b * b / a } else { 0.0 };
            (gain + 0.5 * f * (v + b), work + 0.5 * ((f * v).abs() + (f * b).abs() + motion))
        })
    }
}
