//! Constants of step size control, for the methods that choose their own steps: `StepDoubling` and `EventDriven`.
//!
//! The next step is the present one times SAFETY (tolerance/error)^(1/(p + 1)), p being the order of the error estimate, within limits.
//!
//! # Source
//! Hairer, Nørsett & Wanner, *Solving Ordinary Differential Equations I*, II.4.

/// Part of the step that the error estimate allows [-]: the next error is then below the tolerance in most cases.
pub(super) const SAFETY: f64 = 0.9;
/// Least factor from one step to the next [-]: one bad estimate must not stop the integration.
pub(super) const MIN_FACTOR: f64 = 0.2;
/// Shortest step of `StepDoubling`, relative to dt [-]. At an impact no step is short enough.
pub(super) const SHORTEST_DOUBLED: f64 = 1.0 / 256.0;
/// Shortest step of `EventDriven`, relative to dt [-]. Short enough that a bend of the acceleration costs little accuracy; long enough that
/// alternating contact modes do not stop the integration.
pub(super) const SHORTEST_BETWEEN_EVENTS: f64 = 1e-4;
