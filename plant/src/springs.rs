//! Springs and dampers of joints, k (q0 - q) - d q', integrated implicitly where the method allows it.
//!
//! With semi-implicit Euler, at the end of a step:
//!
//! ```text
//!   H (ẋ₊ - ẋ₋) = h (u - b - d ẋ₊ - k (x + h ẋ₊ - q0)) + KΔf
//!   (H + h d + h² k)(ẋ₊ - ẋ₋) = h (u - b - d ẋ₋ - k (x + h ẋ₋ - q0)) + KΔf
//! ```
//!
//! So they only add to the diagonal of H, and are stable at every h. Evaluated at the beginning of the step, a servo of 3 N·m·s/rad on an
//! ankle of the robot in the air would be unstable above .92 ms. At the middle of a step, reached with the mean velocity ½(ẋ₋ + ẋ₊), the
//! same holds with ½h for h. Methods of higher order use the forces of the present state; both times are then zero.

use crate::factor::{Factor, PathMatrix};
use crate::model::{Model, Spring};
use crate::state::State;

/// Adds τ d + τ² k to the diagonal of H.
pub fn add_to_inertia(model: &Model, tau: f64, inertia: &mut PathMatrix) {
    for spring in &model.springs {
        inertia.add_diagonal(spring.dof, tau * (spring.damping + tau * spring.stiffness));
    }
}

/// Sets [`crate::model::Spring::coupling`] for a pose with this H.
pub fn set_couplings(model: &mut Model, inertia: &PathMatrix, factor: &Factor) {
    let couplings: Vec<f64> = (model.springs.iter())
        .map(|spring| own_inertia(inertia, spring.dof) * factor.mobility(model, spring.dof))
        .map(|coupling| libm::pow(10.0, libm::log10(coupling.max(1.0)).floor()))
        .collect();
    model.springs.iter_mut().zip(couplings).for_each(|(spring, coupling)| spring.coupling = coupling);
}

/// H_ii.
fn own_inertia(inertia: &PathMatrix, dof: usize) -> f64 {
    inertia.row(dof).last().copied().unwrap_or(0.0)
}

/// For all midpoint methods. Adds to the diagonal of H for the middle of a step of h: θ (h d + ½h² k), with θ = ½ + z/(12 + 2z) and
/// z = c h d/H_ii. Stores each θ.
///
/// Spring and damper act at the mean of old and new position, and at the mean velocity (1 - θ)ẋ₋ + θẋ₊. In flight the joint moves by h times
/// that velocity. So the impulse of a damper is d times the distance that the joint moves, however strong the damper is.
///
/// θ = ½ is second order, but with a strong damper the velocity would change its sign at every step. θ = 1 is first order. The formula in
/// between gives the mean of an exponential decay over the step, up to order z³. H_ii/c is the inertia that the damper has to stop, where c
/// is the joint's coupling ([`crate::model::Spring::coupling`]). For a heavy limb on a light base it is the inertia of the base.
pub fn add_to_midpoint_inertia(model: &Model, h: f64, inertia: &mut PathMatrix, end_weights: &mut [f64]) {
    for (spring, theta) in model.springs.iter().zip(end_weights) {
        let z = decay(spring, h, inertia);
        *theta = end_weight(z);
        inertia.add_diagonal(spring.dof, *theta * h * (spring.damping + 0.5 * h * spring.stiffness));
    }
}

/// z of [`add_to_midpoint_inertia`].
fn decay(spring: &Spring, h: f64, inertia: &PathMatrix) -> f64 {
    h * spring.damping * spring.coupling / own_inertia(inertia, spring.dof)
}

/// θ of [`add_to_midpoint_inertia`].
fn end_weight(z: f64) -> f64 {
    0.5 + z / (12.0 + 2.0 * z)
}

/// For an impact before a part of a step, of length h₁, and whole steps of h. Adds τ d to the diagonal of H, and sets `change` to the impulse
/// -τ d ẋ₋ of the dampers:
///
/// ```text
///   τ = (θ₁ - ½) h₁ (1 - r) + (θ - ½) h r,     r = (1 - (1 - θ₁)z₁)/(1 + θ₁z₁)
/// ```
/// In contact a joint moves by the plain mean velocity. With the velocity q' after an impact, of which r q' is left after the part, it would go the
/// distance (H_ii/d + τ) q' until the damper has stopped it: half a step too far if the damper is strong. After this impulse it goes the right
/// distance, q' H_ii/d. If the part is so short that r < 0 makes τ negative, τ is that of a whole step.
pub fn add_to_impact_inertia(
    model: &Model,
    [part, whole]: [f64; 2],
    rate: &[f64],
    inertia: &mut PathMatrix,
    change: &mut [f64],
) {
    change.fill(0.0);
    for spring in &model.springs {
        let z = decay(spring, part, inertia);
        let [in_part, later] = [z, decay(spring, whole, inertia)].map(end_weight);
        let left = (1.0 - (1.0 - in_part) * z) / (1.0 + in_part * z);
        let exact = (in_part - 0.5) * part * (1.0 - left) + (later - 0.5) * whole * left;
        let time = if exact > 0.0 { exact } else { (later - 0.5) * whole };
        inertia.add_diagonal(spring.dof, time * spring.damping);
        change[spring.dof] = -time * spring.damping * rate[spring.dof];
    }
}

/// Moves each joint by the difference of its weighted and its plain mean velocity over `h`, with the weights of
/// [`add_to_midpoint_inertia`]. The rates are those before and after the step.
///
/// Only for steps in flight: in contact it would open gaps. There [`add_to_impact_inertia`] has the same purpose.
pub fn move_by_weighted_mean(model: &Model, end_weights: &[f64], h: f64, [before, after]: [&[f64]; 2], x: &mut [f64]) {
    let offset = x.len() - after.len();
    for (spring, weight) in model.springs.iter().zip(end_weights) {
        x[spring.dof + offset] += h * (weight - 0.5) * (after[spring.dof] - before[spring.dof]);
    }
}

/// Adds k (x + τ ẋ - q0) to b, which already contains d ẋ.
pub fn add_to_bias(model: &Model, state: &State, tau: f64, bias: &mut [f64]) {
    let offset = state.x.len() - state.xdot.len();
    for spring in &model.springs {
        let next = state.x[spring.dof + offset] + tau * state.xdot[spring.dof];
        bias[spring.dof] += spring.stiffness * (next - spring.rest);
    }
}
