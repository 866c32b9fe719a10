//! Springs and dampers on joints, k (q0 - q) - d q', at the end of the step.
//!
//! ```text
//!   H (ẋ₊ - ẋ₋) = h (u - b - d ẋ₊ - k (x + h ẋ₊ - q0)) + KΔf
//!   (H + h d + h² k)(ẋ₊ - ẋ₋) = h (u - b - d ẋ₋ - k (x + h ẋ₋ - q0)) + KΔf
//! ```
//!
//! So they only add to the diagonal of H, and are stable at every h; taken at the beginning, a servo of 3 N·m·s/rad on an
//! ankle of the robot in the air would blow up above .92 ms.

use crate::factor::PathMatrix;
use crate::model::Model;
use crate::state::State;

/// Adds h d + h² k to the diagonal of H, and k (x + h ẋ - q0) to b, which has d ẋ already.
pub fn implicit(model: &Model, state: &State, h: f64, inertia: &mut PathMatrix, bias: &mut [f64]) {
    let offset = state.x.len() - state.xdot.len();
    for spring in &model.springs {
        inertia.add_diagonal(spring.dof, h * (spring.damping + h * spring.stiffness));
        let next = state.x[spring.dof + offset] + h * state.xdot[spring.dof];
        bias[spring.dof] += spring.stiffness * (next - spring.rest);
    }
}

/// Adds k (x - q0) to b: the same at the present state, for methods that take their forces there.
pub fn explicit(model: &Model, state: &State, bias: &mut [f64]) {
    let offset = state.x.len() - state.xdot.len();
    for spring in &model.springs {
        bias[spring.dof] += spring.stiffness * (state.x[spring.dof + offset] - spring.rest);
    }
}
