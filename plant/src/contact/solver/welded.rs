//! The way around A: what links that are welded to the ground make of the bases, judged and corrected as any solution.

use super::super::{Memory, Problem, Report, active_set, lift};
use super::{SOLVED, Solver};
use messages::scene::Law;

impl Solver {
    /// The present bases.
    pub(crate) fn basis(&self) -> &[u8] {
        &self.basis
    }

    /// Takes a solution of Coulomb's law that the present bases made without A, if it is one: `diagonal` is that of A, `velocity` is
    /// A f + b. As in [`Solver::solve`] it is judged by its residual alone.
    pub(crate) fn accept(
        &mut self,
        problem: &Problem,
        [diagonal, impulse, velocity]: [&[f64]; 3],
        memory: &mut Memory,
    ) -> Option<Report> {
        let law = Law::Aligned;
        self.scaled.measure(problem, law, |k| diagonal[k]);
        let Solver { scaled, f, v, .. } = self;
        f.clear();
        f.extend(impulse.iter().zip(&scaled.root).map(|(f, r)| f * r));
        v.clear();
        v.extend(velocity.iter().zip(&scaled.inverse).map(|(v, s)| v * s));
        for (k, i) in (0..v.len()).step_by(scaled.stride()).zip(0..) {
            v[k] += lift(problem, law, i) * scaled.inverse[k];
        }
        self.impulse.clear();
        self.impulse.extend_from_slice(impulse);
        self.velocity.clear();
        self.velocity.extend_from_slice(velocity);
        let mut report = Report { warm: true, ..Report::default() };
        self.measure(problem, law, &mut report);
        if report.natural_map > SOLVED || report.natural_map.is_nan() {
            return None;
        }
        problem.id.iter().zip(&self.basis).for_each(|(&id, &bits)| memory.remember(id, bits));
        (memory.yields, memory.rests) = (true, true);
        Some(report)
    }

    /// Corrects the bases by the solution that was not accepted; false if that changes none.
    pub(crate) fn correct(&mut self) -> bool {
        active_set::correct(&self.scaled, &self.f, &self.v, &mut self.basis, true)
    }
}
