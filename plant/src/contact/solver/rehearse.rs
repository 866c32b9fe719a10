//! Room for every way before the first step, so that none allocates in a step.

use super::super::active_set::RAYS;
use super::super::lemke::{FINE, SHORT};
use super::super::scaled::{HAIR, YIELD};
use super::super::{Memory, Problem};
use super::Solver;
use crate::contact::has_basis;
use messages::scene::Law;

impl Solver {
    /// Goes every way once, with so many contacts that nothing moves: whatever it has room for then, it has room for later.
    pub(crate) fn rehearse(&mut self, contacts: usize, tangents: usize, law: Law) {
        if !has_basis(law) || contacts == 0 {
            return;
        }
        let mut problem = Problem::default();
        problem.reset(contacts, tangents);
        let next = problem.rows() + 1;
        problem.delassus.iter_mut().step_by(next).for_each(|a| *a = 1.0);
        problem.friction.fill(1.0);
        self.solve(&problem, law, &mut Memory::default());
        let every_ray = (1 << self.scaled.facets()) - 1;
        let mut pivots = 0;
        for care in [SHORT, FINE] {
            self.pivot(law, care, &mut pivots);
        }
        // the largest blocks: rigid contacts that stick, and all rays of those that yield
        self.basis.fill(every_ray << 1 | 1);
        self.is_solved(law);
        self.basis.fill(every_ray | RAYS);
        self.yielding(YIELD, |solver| {
            solver.is_solved(law);
            let stride = solver.scaled.stride(); // impulses within their cones, for as many rays as may join
            solver.f.iter_mut().enumerate().for_each(|(k, f)| *f = if k % stride == 0 { 1.0 } else { 0.1 });
            solver.slide(law, &mut pivots)
        });
        self.yielding(HAIR, |solver| solver.pivot_exactly(law, &mut pivots));
    }
}
