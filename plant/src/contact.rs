//! Contact with the ground: which impulse f makes the velocity after the step, v = A f + b, obey the contact law?
//!
//! | law | conditions | method |
//! |---|---|---|
//! | `EnergyQp` | the minimum of (14) under (15), (16), as printed | principal pivoting |
//! | `EnergyQpGap` | the same with two tangents and v_N + gap/h >= mu |v_F|, as convex engines have it \[1\] | the same |
//! | `Complementarity` | (17)-(22), one tangent | the program, shifted along a path; Lemke in 32 digits |
//! | `Aligned` | (17)-(22), two tangents, landing at the ground | the same |
//! | `Facets(d)` | (17)-(22), d directions fixed in the world \[2\] | semismooth Newton, Lemke behind it |
//! | `Cone` | (17)-(22), round cone \[3\] | Newton over patches and contacts, interior points (`coulomb`) |
//! | `FixedPoint(Tresca)`, `(Aclm)` | the same as the limit of energy minima \[4\] | semismooth Newton |
//! | `ConeQp` | the minimum of (14) over round cones | interior points, clarabel |
//! | `Lagged` | that with |f_F| <= mu f_N of the step before \[5\] | semismooth Newton |
//! | `Sweep(n)` | `Cone`, as near as n sweeps come \[6\] | projected Gauss-Seidel |
//! | `SpringDamper` | none: springs, dampers, regularised friction | a formula |
//!
//! The default, `Cone`, stands in `contact/coulomb.rs` with all that it needs beside it here; the others are in `contact/compared.rs`.
//! Whatever a law is solved by, the impulse is accepted by its residual alone, and the certificate of every law is that of the round cone
//! (`contact/certificate.rs`).
//!
//! \[1\] Anitescu 2006; Tasora & Anitescu 2011; Todorov 2011. \[2\] Stewart & Trinkle 1996; Anitescu & Potra 1997.
//! \[3\] De Saxcé & Feng 1998; Alart & Curnier 1991. \[4\] Haslinger 1983; Acary, Cadoux, Lemaréchal & Malick 2011.
//! \[5\] Lötstedt 1984. \[6\] Moreau 1999; Jourdan, Alart & Jean 1998.
//!
//! The paper takes (17)-(22) for the conditions of its program (14)-(16). They are not: with multipliers the program gives
//! f_N (v_N - mu |v_F|) = 0 in place of (19), so whatever slides is thrown up. See docs/PAPER.md.

mod certificate;
mod compared;
mod coulomb;
mod law;
mod lu;
mod memory;
mod problem;
mod projection;
mod round_cones;
mod solver;
mod tolerance;

pub(crate) use certificate::relative;
use law::approach_offset;
pub use law::{has_basis, is_coulomb, is_plastic, tangents};
pub use memory::Memory;
pub use problem::{ContactSpring, Problem};
pub use solver::Solver;
pub use tolerance::PROMISED;
pub(crate) use tolerance::{COLLINEAR, COMPLIANCE, PULL_ROUNDING, STANDING_BOUND, STANDING_REDUCTION, WELL_SOLVED};

/// How well a step was solved, and how.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Report {
    /// Natural map of (17)-(22), ||f - P_K(f - v^)||, relative to the step's scale max(||f||, ||b||), all scaled by the
    /// diagonal of A into sqrt(J). The same yardstick for every law; `EnergyQp` violates it by design when it slides.
    pub natural_map: f64,
    /// The same map for the law's own problem: it says that the solver did its work.
    pub own: f64,
    /// Greatest |f_N v_N| of (19), relative to the square of the step's scale; v_N counts from the allowed approach.
    pub signorini: f64,
    /// Greatest angle between f_F and -v_F at a slipping contact \[rad\].
    pub slip_misalignment: f64,
    /// Energy after the step less that of the free motion, f·v - f·A f/2 \[J\]. Plastic contact never raises it.
    pub energy_gain: f64,
    /// What the gain is to be seen beside: work of the impulses, and energy of motion that the contacts could take \[J\].
    pub work: f64,
    /// Pivots of all attempts; of the round cone, linear systems solved.
    pub pivots: u32,
    /// The remembered basis was right (of no contact: that nothing touches).
    pub warm: bool,
    /// Pivoting failed on the problem itself and went through a regularised one; see `own` for how well that ended.
    pub fallback: bool,
}
