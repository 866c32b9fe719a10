//! Coulomb's law as the limit of energy minima. With this iteration, the paper's program (14)-(16) leads to the law (17)-(22).
//!
//! - `Tresca`: minimise with friction bounded by μ f_N of the last minimum, until the bound no longer changes.
//! - `Aclm`: minimise over the cone with μ |v_F| of the last minimum added to v_N, until the shift no longer changes. The minimum has v_N
//!   >= μ |v_F|, so the shift cancels the spurious normal velocity of the program (De Saxcé). The first minimum is the program itself.
//!
//! Each minimum is exact. If all contacts stick, a few minima suffice. If a contact slides, each minimum reduces the error by a constant
//! factor, and tens are needed. At high friction the iteration may oscillate without end; under-relaxation then damps it. With redundant
//! contacts it may creep along directions that hardly change the energy; over-relaxation then speeds it up.
//!
//! # Source
//! Haslinger 1983 (Tresca). Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction problem via convex
//! optimization*, ZAMM 91, 2011.

use super::super::tolerance::{
    ACCELERATION, DAMPING, FIXED_POINT_PATIENCE, FIXED_POINT_PROGRESS, MAX_MINIMA, PROMISED, SOLVED,
};
use super::condition::Condition;
use super::cone_solver::ConeSolver;
use messages::scene::Iteration;

impl ConeSolver {
    /// Iterates from the present impulse; false if that does not converge. Adds the minima to `count`.
    pub(super) fn iterate_fixed_point(&mut self, iteration: Iteration, count: &mut u32) -> bool {
        let (mut least, mut stalled, mut relaxation, mut is_monotone) = (f64::INFINITY, 0, 1.0, false);
        self.held.clear();
        for _ in 0..MAX_MINIMA {
            let error = self.residual(Condition::Coulomb);
            if error <= SOLVED {
                return true;
            }
            stalled += 1;
            if error < FIXED_POINT_PROGRESS * least {
                (least, stalled) = (error, 0);
            } else if stalled > FIXED_POINT_PATIENCE {
                (least, stalled, relaxation) =
                    (error, 0, if is_monotone { ACCELERATION * relaxation } else { DAMPING * relaxation });
            }
            is_monotone = self.hold(iteration, relaxation);
            *count += 1;
            self.with_held(|solver, held| {
                let condition = match iteration {
                    Iteration::Tresca => Condition::Bound(held),
                    Iteration::Aclm => Condition::Energy(held),
                };
                solver.minimise(condition, &mut 0)
            });
        }
        self.residual(Condition::Coulomb) <= PROMISED
    }
}
