//! Allocation for every attempt before the first step, so that no step allocates.

use super::super::super::memory::Memory;
use super::super::super::problem::Problem;
use super::super::super::tolerance::{COMPLIANCE, LEMKE_COMPLIANCE};
use super::super::status::EDGES;
use super::BasisSolver;
use messages::scene::Law;

impl BasisSolver {
    /// Runs every attempt once with this many contacts that do not move. All buffers then have their greatest size.
    pub fn reserve_for(&mut self, contacts: usize, tangents: usize, law: Law) {
        let mut problem = Problem::default();
        problem.reset(contacts, tangents);
        let next = problem.rows() + 1;
        problem.delassus.iter_mut().step_by(next).for_each(|a| *a = 1.0);
        problem.friction.fill(1.0);
        self.solve(&problem, law, &mut Memory::default(), &mut Vec::new());
        let every_edge = (1 << self.scaled.facets()) - 1;
        let mut pivots = 0;
        // the largest systems: all contacts stick, and all edges are basic
        for basis in [every_edge << 1 | 1, every_edge | EDGES] {
            self.basis.fill(basis);
            self.with_compliance(COMPLIANCE, |solver| solver.try_basis(law));
        }
        self.with_compliance(COMPLIANCE, |solver| solver.energy_stage(law, &mut pivots));
        self.shift.reserve_for(&self.scaled);
        self.with_compliance(LEMKE_COMPLIANCE, |solver| solver.lemke_stage(law, &mut pivots));
    }
}
