//! Contact with the ground: find the impulse f for which the velocity after the step, v = A f + b, obeys the contact law.
//!
//! | law | conditions | method |
//! |---|---|---|
//! | `EnergyQp` | the minimum of (14) under (15), (16), as printed | principal pivoting |
//! | `EnergyQpGap` | the same with two tangents and v_N + gap/h >= μ |v_F|, as in engines with a convex contact model \[1\] | the same |
//! | `Complementarity` | (17)-(22), one tangent | the energy program with a shift that is followed along a path; Lemke's method with 32 digits |
//! | `Aligned` | (17)-(22), two tangents, a contact may close its gap | the same |
//! | `Facets(d)` | (17)-(22), d directions fixed in the world \[2\] | semismooth Newton, then Lemke's method |
//! | `Cone` | (17)-(22), round cone \[3\] | Newton over patches and contacts, then interior points (`coulomb`) |
//! | `FixedPoint(Tresca)`, `(Aclm)` | (17)-(22), round cone, as the limit of energy minima \[4\] | semismooth Newton |
//! | `ConeQp` | the minimum of (14) over round cones | interior points, clarabel |
//! | `Lagged` | the minimum of (14) with |f_F| <= μ f_N of the step before \[5\] | semismooth Newton |
//! | `Sweep(n)` | the round cone, approximated by n sweeps \[6\] | projected Gauss-Seidel |
//! | `SpringDamper` | none: springs, dampers, regularised friction | a formula |
//!
//! `contact/coulomb.rs` holds the default law, `Cone`. `contact/compared.rs` holds the others. The files beside them serve both. Every
//! law's impulse is accepted by its residual alone, independently of the method that found it. Every law also gets the same certificate:
//! its distance from Coulomb's law with the round cone (`contact/certificate.rs`).
//!
//! \[1\] Anitescu 2006; Tasora & Anitescu 2011; Todorov 2011. \[2\] Stewart & Trinkle 1996; Anitescu & Potra 1997.
//! \[3\] De Saxcé & Feng 1998; Alart & Curnier 1991. \[4\] Haslinger 1983; Acary, Cadoux, Lemaréchal & Malick 2011.
//! \[5\] Lötstedt 1984. \[6\] Moreau 1999; Jourdan, Alart & Jean 1998.
//!
//! The paper states that (17)-(22) are the optimality conditions of its program (14)-(16). They are not. With multipliers, the program
//! gives f_N (v_N - μ |v_F|) = 0 in place of (19), so a sliding contact leaves the ground with v_N = μ |v_F|. See docs/PAPER.md.

mod certificate;
mod compared;
mod coulomb;
mod law;
mod lu;
mod memory;
mod mode;
mod problem;
mod projection;
mod report;
mod round_cones;
mod solver;
mod tolerance;

pub(crate) use certificate::relative;
pub use law::{disc, has_basis, is_coulomb, is_plastic, stops_at_any_height, tangents};
pub use memory::Memory;
pub use problem::{ContactSpring, Problem};
pub use report::Report;
pub use solver::Solver;
pub use tolerance::PROMISED;
pub(crate) use tolerance::{
    COLLINEAR, COMPLIANCE, OVERREDUCTION, PULL_ROUNDING, STANDING_BOUND, STANDING_REDUCTION, WELL_SOLVED,
};
