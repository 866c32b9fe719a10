//! Observers by which the plan follows the robot: each pendulum is corrected by the measured centre of gravity.
//!
//! ```text
//!   x̂ += l_x (x − x̂)      l_x = 1 − e^(−2ph)
//!   v̂ += l_v (x − x̂)      l_v = (1 − e^(−ph))²/h
//! ```
//! x is measured by the encoders and the kinematics of the supporting leg (25). Between corrections x̂ and v̂ move by (31), (32)
//! with the input that the controller chose, so the estimate has no delay. Both errors decay as e^(−pt). Only the position is
//! used, because measured rates are noisy when a foot lands. With p = 0 the plan ignores the measurement.
//!
//! The plan agrees with the robot only if the robot has no delay either: see [`servo_lag`].

use crate::constants::MATRIX_MARGIN;
use messages::scene::{ControllerScene, NominalInertia, Switching};
use std::f64::consts::TAU;

/// Time by which the measured rate lags behind the reference [control periods]. A rate is a mean over one period, so it is half a
/// period late. The plan looks one period ahead.
const SAMPLING_LEAD: f64 = 1.5;

/// Pole of the observers in phase *rest*, relative to that of the walk [-]. Two legs on the ground are a closed chain, which the servos hold with less
/// reserve. With the whole pole a robot that has stopped falls at a delay of 4 ms if J_n is a number for each joint, and at 5 ms, mostly, if its
/// encoders have 13 bits.
pub const RESTING_POLE: f64 = 0.4;

/// Gains of the observers.
#[derive(Clone, Copy, Debug)]
pub struct Observer {
    /// l_x [-].
    pub position: f64,
    /// l_v [1/s].
    pub rate: f64,
}

impl Observer {
    /// An observer whose errors decay at the rate `pole`, p [1/s], sampled once each `h` [s].
    pub fn new(pole: f64, h: f64) -> Observer {
        let kept = libm::exp(-pole * h);
        Observer { position: 1.0 - kept * kept, rate: (1.0 - kept).powi(2) / h }
    }

    /// Whether the observer is off: p = 0.
    pub fn is_disabled(&self) -> bool {
        self.position == 0.0
    }
}

/// Delay of a joint rate after its reference, for a motion that grows as e^(ωt) [s].
///
/// ```text
///   σ = −(1 − (1 − 1/λ) S) q̈/κ      λ = J_n/M,  S = ω/(ω + g)
/// ```
/// This follows from the torque and the observer of the servo (`servo.rs`) with M q̈ = τ − τ_ff. A number for each joint has no single λ;
/// then S is ignored. The servo compares the reference with measured rates that are late themselves. So the lag of their filter,
/// 1/(2π f), and [`SAMPLING_LEAD`] are subtracted. The relay has no such lag.
///
/// Without this lead the plan runs ahead of the robot, the observer holds the plan back, and the steps last .70 s instead of .60.
pub fn servo_lag(scene: &ControllerScene, omega: f64, h: f64) -> f64 {
    let sensitivity = omega / (omega + scene.observer_bandwidth);
    let sooner = match scene.nominal_inertia() {
        NominalInertia::Matrix => (1.0 - 1.0 / MATRIX_MARGIN) * sensitivity,
        NominalInertia::Diagonal => 0.0,
    };
    match scene.switching {
        Switching::Relay => 0.0,
        Switching::BoundaryLayer => {
            ((1.0 - sooner) / scene.switch_rate - 1.0 / (TAU * scene.rate_filter_hz) - SAMPLING_LEAD * h).max(0.0)
        }
    }
}
