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

use super::super::tolerance::{PROMISED, SOLVED};
use super::cones::Cones;
use super::rule::Rule;
use messages::scene::Iteration;

/// Minima at most.
const MINIMA: u32 = 200;
/// Minima without progress before it becomes more cautious, or bolder.
const PATIENCE: u32 = 6;

/// Iterates from the present impulse; false if that does not settle. Adds the minima to `count`.
pub(super) fn iterate(cones: &mut Cones, iteration: Iteration, count: &mut u32) -> bool {
    let (mut least, mut waited, mut share, mut creeps) = (f64::INFINITY, 0, 1.0, false);
    cones.held.clear();
    for _ in 0..MINIMA {
        let error = cones.residual(Rule::Coulomb);
        if error <= SOLVED {
            return true;
        }
        waited += 1;
        if error < 0.9 * least {
            (least, waited) = (error, 0);
        } else if waited > PATIENCE {
            (least, waited, share) = (error, 0, if creeps { 2.0 * share } else { 0.5 * share });
        }
        creeps = cones.hold(iteration, share);
        *count += 1;
        cones.with_held(|cones, held| {
            let rule = match iteration {
                Iteration::Tresca => Rule::Bound(held),
                Iteration::Aclm => Rule::Energy(held),
            };
            cones.minimise(rule, &mut 0)
        });
    }
    cones.residual(Rule::Coulomb) <= PROMISED
}
