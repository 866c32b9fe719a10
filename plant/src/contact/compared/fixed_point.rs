//! Coulomb's law as the limit of energy minima: what the paper's program (14)-(16) needs to become the law it was meant for.
//!
//! - `Tresca`: minimise with friction bounded by mu f_N of the last minimum, until that is the same.
//! - `Aclm`: minimise over the cone with mu |v_F| of the last minimum added to v_N, until that is the same. The minimum has
//!   v_N >= mu |v_F|, so the shift takes back what the program lifts (De Saxcé). Its first minimum is the program itself.
//!
//! Each minimum is exact. Where everything sticks a few of them do; where something slides each leaves a share of the
//! error, and it takes tens. At high friction the two-step of overshooting both ways can go on for ever: then what is
//! carried over is averaged with what was carried before, ever more cautiously. And where contacts are redundant the minima may
//! creep along what hardly changes the energy: then it goes farther than they say, ever more boldly.
//!
//! # Source
//! Haslinger 1983 (Tresca). Acary, Cadoux, Lemaréchal & Malick, *A formulation of the linear discrete Coulomb friction
//! problem via convex optimization*, ZAMM 91, 2011.

use super::super::tolerance::{ACCELERATION, DAMPING, FIXED_POINT_PROGRESS, PROMISED, SOLVED};
use super::condition::Condition;
use super::cone_solver::ConeSolver;
use messages::scene::Iteration;

/// Minima at most.
const MAX_MINIMA: u32 = 200;
/// Minima without progress before it becomes more cautious, or bolder.
const PATIENCE: u32 = 6;

/// Iterates from the present impulse; false if that does not settle. Adds the minima to `count`.
pub(super) fn iterate(solver: &mut ConeSolver, iteration: Iteration, count: &mut u32) -> bool {
    let (mut least, mut stalled, mut relaxation, mut is_monotone) = (f64::INFINITY, 0, 1.0, false);
    solver.held.clear();
    for _ in 0..MAX_MINIMA {
        let error = solver.residual(Condition::Coulomb);
        if error <= SOLVED {
            return true;
        }
        stalled += 1;
        if error < FIXED_POINT_PROGRESS * least {
            (least, stalled) = (error, 0);
        } else if stalled > PATIENCE {
            (least, stalled, relaxation) =
                (error, 0, if is_monotone { ACCELERATION * relaxation } else { DAMPING * relaxation });
        }
        is_monotone = solver.hold(iteration, relaxation);
        *count += 1;
        solver.with_held(|solver, held| {
            let condition = match iteration {
                Iteration::Tresca => Condition::Bound(held),
                Iteration::Aclm => Condition::Energy(held),
            };
            solver.minimise(condition, &mut 0)
        });
    }
    solver.residual(Condition::Coulomb) <= PROMISED
}
