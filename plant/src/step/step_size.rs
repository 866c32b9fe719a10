//! Constants of step size control, for the methods that choose their own steps.
//!
//! The next step is the present one times SAFETY (tolerance/error)^(1/(p + 1)), p being the order of the error estimate, within limits.
//!
//! # Source
//! Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.4.

/// Part of the step that the error estimate allows [-]: the next error is then below the tolerance in most cases.
pub(super) const SAFETY: f64 = 0.9;
/// Least factor from one step to the next [-]: one bad estimate must not stop the integration.
pub(super) const MIN_FACTOR: f64 = 0.2;
