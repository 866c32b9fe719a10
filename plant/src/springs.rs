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
pub fn stiffen(model: &Model, tau: f64, inertia: &mut PathMatrix) {
    for spring in &model.springs {
        inertia.add_diagonal(spring.dof, tau * (spring.damping + tau * spring.stiffness));
    }
}

/// Adds k (x + τ ẋ - q0) to b, which has d ẋ already.
pub fn pull(model: &Model, state: &State, tau: f64, bias: &mut [f64]) {
    let offset = state.x.len() - state.xdot.len();
    for spring in &model.springs {
        let next = state.x[spring.dof + offset] + tau * state.xdot[spring.dof];
        bias[spring.dof] += spring.stiffness * (next - spring.rest);
    }
}
