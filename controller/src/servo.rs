//! The robust servo of each joint: sliding mode on the rate with a disturbance observer, (23)-(24).
//!
//! ```text
//!   nominal drive  J_n q̈ = τ − d'                         (23) with B as part of d'
//!   surface        σ = q̇ − q̇_ref
//!   torque         τ = τ_ff − J_n sat(κσ) + d̂,   κ = 1/T_s
//!   observer       d̂ = (1 − S)(τ − τ_ff − J_n q̈),  S(s) = s/(s + g)
//! ```
//! If the switching element brings σ to zero in one switching period, σ_{k+1} = T_s (K_n/J_n) S d', which is (24). The paper's
//! switching element is a relay. In a sampled loop a relay chatters between the torque limits, so the default is a saturation
//! with a boundary layer.
//!
//! J_n is a matrix by default, so that the torque of one joint accounts for the accelerations of the others: docs/DESIGN.md. The paper has
//! a number for each joint, and so a diagonal matrix.
//!
//! J_n is that of a robot on one foot. The servos of a leg whose foot carries little weight move little more than this leg, and shake at a delay
//! with that J_n. So with the share s of the weight on the supporting foot, [`Reference::support`](crate::gait::Reference::support),
//! ```text
//!   torque         τ = τ_ff − J sat(κσ) + d̂,   J = s⁴ J_n + (1 − s)⁴ J'_n
//! ```
//! J'_n is J_n with the other foot as the supporting one. On equal feet J is an eighth of their mean. The paper's numbers stay as they are.

use crate::support::{JointMatrix, Joints, mirror};
use messages::scene::{ControllerScene, NominalInertia, Switching};
use messages::wire::JOINTS;

/// Acceleration of the relay toward the sliding surface [rad/s²]. The paper gives no value; this one is chosen (docs/PAPER.md).
const RELAY_ACCELERATION: f64 = 60.0;
/// Largest acceleration of the boundary layer toward the sliding surface [rad/s²]. A robot that is pushed needs more than
/// [`RELAY_ACCELERATION`], and unlike the relay the boundary layer uses it only then.
const SATURATION_ACCELERATION: f64 = 180.0;
/// Constants of the eight servos, support order.
#[derive(Clone, Debug)]
pub struct ServoModel {
    /// J_n [kg·m²].
    pub nominal_inertia: JointMatrix,
    /// J'_n [kg·m²]; `None` if J_n does not depend on the load of the feet.
    other_inertia: Option<JointMatrix>,
    /// Largest acceleration that the switching element demands [rad/s²].
    pub max_acceleration: f64,
    /// κ = 1/T_s [1/s].
    pub switch_rate: f64,
    /// g [rad/s].
    pub observer_bandwidth: f64,
    /// Relay or boundary layer.
    pub switching: Switching,
    /// Control period [s].
    pub period: f64,
}

/// State of the eight servos, support order.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct ServoState {
    /// d̂ [N·m].
    pub disturbance: Joints,
    /// q̇ of the period before [rad/s].
    rate: Option<Joints>,
    /// Torque beyond the feed-forward that was applied in the period before [N·m].
    effort: Joints,
}

impl ServoModel {
    /// Servos of a scene with this nominal inertia [kg·m²], sampled once each `period` [s]. `scale` is the ratio of the robot's
    /// times to those of Table 1.
    pub fn new(scene: &ControllerScene, nominal_inertia: JointMatrix, period: f64, scale: f64) -> Self {
        let table_1 = match scene.switching {
            Switching::BoundaryLayer => SATURATION_ACCELERATION,
            Switching::Relay => RELAY_ACCELERATION,
        };
        ServoModel {
            nominal_inertia,
            other_inertia: (scene.nominal_inertia() == NominalInertia::Matrix).then(|| swapped(&nominal_inertia)),
            max_acceleration: table_1 / (scale * scale),
            switch_rate: scene.switch_rate,
            observer_bandwidth: scene.observer_bandwidth,
            switching: scene.switching,
            period,
        }
    }

    /// J for the share `support` of the weight on the supporting foot [kg·m²].
    fn inertia(&self, support: f64) -> JointMatrix {
        match &self.other_inertia {
            Some(other) if support < 1.0 => {
                // With s² a robot that stops still shakes at a delay of 4 ms; with s⁶ it is too soft against pushes from the side.
                let fourth = |s: f64| (s * s) * (s * s);
                self.nominal_inertia * fourth(support) + other * fourth(1.0 - support)
            }
            _ => self.nominal_inertia,
        }
    }

    /// Rate bounds that keep the torque of [`drive`](Self::drive) within ±`bound` [N·m] inside the boundary layer:
    /// q̇ + (±bound − τ_ff − d̂)/(J_n κ), from τ = τ_ff + d̂ + J_n κ (q̇_ref − q̇), for a diagonal J_n.
    pub fn rates_within(&self, state: &ServoState, rate: &Joints, feed_forward: &Joints, bound: f64) -> [Joints; 2] {
        let slope = self.nominal_inertia.diagonal() * self.switch_rate;
        let idle = feed_forward + state.disturbance;
        [-bound, bound].map(|limit| rate + (Joints::repeat(limit) - idle).component_div(&slope))
    }

    /// Updates the disturbance observers with the present rates [rad/s], and returns the acceleration [rad/s²]. The disturbance is the
    /// part of it that the effort of the last period does not explain.
    pub fn observe(&self, state: &mut ServoState, rate: &Joints) -> Joints {
        let acceleration = state.rate.map_or_else(Joints::zeros, |before| (rate - before) / self.period);
        if state.rate.is_some() {
            let forget = libm::exp(-self.observer_bandwidth * self.period);
            let unexplained = state.effort - self.nominal_inertia * acceleration;
            state.disturbance = state.disturbance * forget + unexplained * (1.0 - forget);
        }
        state.rate = Some(*rate);
        acceleration
    }

    /// Torques that drive the rates to `reference`, within `limits` [N·m], and the sliding variables σ. `support` is the share of the weight on
    /// the supporting foot [-].
    pub fn drive(
        &self,
        state: &mut ServoState,
        rate: &Joints,
        reference: &Joints,
        feed_forward: &Joints,
        limits: &[Joints; 2],
        support: f64,
    ) -> (Joints, Joints) {
        let surface = rate - reference; // σ
        let switch = surface.map(|sigma| match self.switching {
            Switching::BoundaryLayer => (self.switch_rate * sigma).clamp(-self.max_acceleration, self.max_acceleration),
            Switching::Relay if sigma == 0.0 => 0.0,
            Switching::Relay => self.max_acceleration.copysign(sigma),
        });
        let wanted = feed_forward + state.disturbance - self.inertia(support) * switch;
        let [low, high] = limits;
        let torque = wanted.zip_zip_map(low, high, |torque: f64, low: f64, high: f64| torque.max(low).min(high));
        state.effort = torque - feed_forward; // after the limit: otherwise the observer would wind up
        (torque, surface)
    }

    /// Transforms the state to the other support order. The disturbance of the new swing leg is set to zero: it contains the load
    /// of the ground, which would turn the free ankle.
    pub fn exchange(&self, state: &mut ServoState) {
        state.disturbance = mirror(&state.disturbance);
        state.effort = mirror(&state.effort);
        state.rate = state.rate.map(|rate| mirror(&rate));
        for j in JOINTS / 2..JOINTS {
            state.disturbance[j] = 0.0;
        }
    }
}

/// A matrix with the other foot as the supporting one.
fn swapped(matrix: &JointMatrix) -> JointMatrix {
    let swap = JointMatrix::from_columns(&std::array::from_fn::<Joints, JOINTS, _>(|j| mirror(&Joints::ith(j, 1.0))));
    swap * matrix * swap
}
