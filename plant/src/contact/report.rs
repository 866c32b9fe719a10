//! Report on the solution of a contact problem.

use super::tolerance::PROMISED;

/// Quality and cost of the solution of one contact problem.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Report {
    /// Greatest natural map of (17)-(22) with the round cone, |f - P_K(f - (F/V) v̂)| / F, of all contacts; F and V are the contact's own
    /// scales. It is the same measure for every law. `EnergyQp` violates it by design when a contact slides.
    pub natural_map: f64,
    /// The same map for the conditions of the law itself: it measures the solver, not the law.
    pub own: f64,
    /// Greatest |f_N v_N| of (19), relative to the contact's scales; −v_N/V if a contact enters the ground with more than half of V. v_N
    /// counts from the allowed approach.
    pub signorini: f64,
    /// Greatest angle between f_F and -v_F at a slipping contact \[rad\].
    pub slip_misalignment: f64,
    /// Energy after the step minus the energy of the free motion, f·v - f·A f/2 \[J\]. Plastic contact never raises it.
    pub energy_gain: f64,
    /// Scale for the energy gain: work of the impulses, and kinetic energy that the contacts could take \[J\].
    pub work: f64,
    /// Pivots of all attempts; for the round cone, the number of linear systems solved.
    pub pivots: u32,
    /// The memory was nearly the solution: feet that stand, one linear system, or the remembered basis of a law with a basis.
    pub warm: bool,
    /// No attempt met the tolerance of the problem itself; `own` holds the residual of the best attempt. It is always set if `own` of
    /// `Cone` or of a law with a basis exceeds 1e-10.
    pub fallback: bool,
}

impl Report {
    /// Whether `own` exceeds the promised 1e-10, or is NaN.
    pub fn breaks_promise(&self) -> bool {
        self.own.is_nan() || self.own > PROMISED
    }
}
