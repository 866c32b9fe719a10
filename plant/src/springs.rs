//! Springs and dampers on joints, k (q0 - q) - d q', as stable as the method that they act in.
//!
//! At the end of a step of Euler's:
//!
//! ```text
//!   H (ẋ₊ - ẋ₋) = h (u - b - d ẋ₊ - k (x + h ẋ₊ - q0)) + KΔf
//!   (H + h d + h² k)(ẋ₊ - ẋ₋) = h (u - b - d ẋ₋ - k (x + h ẋ₋ - q0)) + KΔf
//! ```
//!
//! So they only add to the diagonal of H, and are stable at every h; taken at the beginning, a servo of 3 N·m·s/rad on an
//! ankle of the robot in the air would blow up above .92 ms. In the middle of a step, where the mean velocity ½(ẋ₋ + ẋ₊) has
//! led, the same holds with ½h for h on the diagonal. Methods of higher order take the forces of the present state, for
//! which both times are zero.

use crate::factor::PathMatrix;
use crate::model::Model;
use crate::state::State;

/// Adds τ d + τ² k to the diagonal of H.
pub fn add_to_inertia(model: &Model, tau: f64, inertia: &mut PathMatrix) {
    for spring in &model.springs {
        inertia.add_diagonal(spring.dof, tau * (spring.damping + tau * spring.stiffness));
    }
}

/// The same for the middle of a step of h, with the mean velocity: θ h d + ¼h² k, θ = ½ + z/(12 + 2z), z = h d/H_ii.
///
/// θ = ½ is of second order, but what a strong damper should stop would change its sign at every step; θ = 1 is not. Between them this is the
/// part of the step in which an exponential decay acts, to the order of z³.
pub fn add_to_midpoint_inertia(model: &Model, h: f64, inertia: &mut PathMatrix) {
    for spring in &model.springs {
        let own = inertia.row(spring.dof).last().copied().unwrap_or(0.0);
        let z = h * spring.damping / own;
        let theta = 0.5 + z / (12.0 + 2.0 * z);
        inertia.add_diagonal(spring.dof, h * (theta * spring.damping + 0.25 * h * spring.stiffness));
    }
}

/// Adds k (x + τ ẋ - q0) to b, which has d ẋ already.
pub fn add_to_bias(model: &Model, state: &State, tau: f64, bias: &mut [f64]) {
    let offset = state.x.len() - state.xdot.len();
    for spring in &model.springs {
        let next = state.x[spring.dof + offset] + tau * state.xdot[spring.dof];
        bias[spring.dof] += spring.stiffness * (next - spring.rest);
    }
}
