//! The solver: the default law or one of those it is compared with, and the certificate of what it found.

use super::certificate::Evaluator;
use super::compared::Compared;
use super::coulomb::Coulomb;
use super::round_cones::apply_delassus;
use super::{Memory, Problem, Report};
use messages::scene::Law;

/// Solver of contact problems: workspace and last solution. With [`Memory`] kept it may be dropped between steps without
/// changing results.
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
    /// Nothing is allocated up to the size that was rehearsed or met before, but by some laws without a basis. Where the law has one
    /// velocity as its answer, v is the same warm or cold to the residual; f may differ by what A does not see. (The energy minimum
    /// always has one. Coulomb's law has several in jammed arrangements at high friction; then either is valid.)
    pub fn solve(&mut self, problem: &Problem, law: Law, memory: &mut Memory) -> Report {
        let report = match law {
            Law::Cone => self.coulomb.solve(problem, memory, &mut self.impulse),
            _ => self.compared.solve(problem, law, memory, &mut self.impulse),
        };
        self.certify(problem, law, report)
    }

    /// Residuals of a given impulse, as a yardstick for any other solver.
    pub fn measure_impulse(&mut self, problem: &Problem, law: Law, impulse: &[f64]) -> Report {
        self.impulse.clear();
        self.impulse.extend_from_slice(impulse);
        let own = match law {
            Law::Cone => 0.0,
            _ => self.compared.own_residual(problem, law, impulse),
        };
        self.certify(problem, law, Report { own, ..Report::default() })
    }

    /// Makes room before the first step, so that none allocates.
    pub(crate) fn reserve_for(&mut self, contacts: usize, tangents: usize, law: Law) {
        self.compared.reserve_for(contacts, tangents, law);
    }

    /// Velocity, the residuals of Coulomb's law with the round cone, and the energy.
    fn certify(&mut self, problem: &Problem, law: Law, report: Report) -> Report {
        apply_delassus(&problem.delassus, &problem.drift, &self.impulse, &mut self.velocity);
        let residual = self.evaluator.evaluate(problem, law, &self.impulse, &self.velocity);
        let (energy_gain, work) = self.energy(problem);
        Report {
            natural_map: residual.natural_map,
            own: if law == Law::Cone { residual.natural_map } else { report.own },
            signorini: residual.signorini,
            slip_misalignment: residual.misalignment,
            energy_gain,
            work,
            ..report
        }
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
