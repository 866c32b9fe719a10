//! Room for every way before the first step, so that none allocates in a step.

use super::super::lemke::FINE;
use super::super::scaled::{HAIR, YIELD};
use super::super::status::EDGES;
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
        let every_edge = (1 << self.scaled.facets()) - 1;
        let mut pivots = 0;
        self.pivot(law, FINE, &mut pivots);
        // the largest blocks: contacts that stick, and all edges
        for basis in [every_edge << 1 | 1, every_edge | EDGES] {
            self.basis.fill(basis);
            self.while_yielding(YIELD, |solver| solver.is_solved(law));
        }
        self.while_yielding(YIELD, |solver| solver.slide(law, &mut pivots));
        self.shift.rehearse(&self.scaled);
        self.while_yielding(HAIR, |solver| solver.pivot_exactly(law, &mut pivots));
    }
}
