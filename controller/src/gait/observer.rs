//! The plan follows the robot: an observer of each pendulum, corrected by the measured centre of gravity.
//!
//! ```text
//!   x̂ += l_x (x − x̂)      l_x = 1 − e^(−2ph)
//!   v̂ += l_v (x − x̂)      l_v = (1 − e^(−ph))²/h
//! ```
//! x is what encoders and the supporting foot's kinematics say (25). Between corrections x̂ and v̂ move as (31), (32) say, with the input
//! that the controller itself chose, so the estimate is not late. Both errors decay as e^(−pt). Only the position is measured: rates are
//! noisy where a foot lands. With p = 0 nothing is corrected, and the plan is an oscillator that does not look at the robot.
//!
//! The other half of a plan that agrees with the robot is that the robot is not late either: see [`lag`].

use super::{GaitModel, GaitState};
use crate::support::Task;
use messages::scene::{ControllerScene, Sagittal, Switching};
use std::f64::consts::TAU;

/// Gains of the observers.
#[derive(Clone, Copy, Debug)]
pub struct Observer {
    /// l_x [-].
    position: f64,
    /// l_v [1/s].
    rate: f64,
}

impl Observer {
    /// An observer whose errors decay at the rate `pole`, p [1/s], sampled each `h` [s].
    pub fn new(pole: f64, h: f64) -> Observer {
        let kept = (-pole * h).exp();
        Observer { position: 1.0 - kept * kept, rate: (1.0 - kept).powi(2) / h }
    }

    /// Whether nothing is corrected.
    pub fn is_disabled(&self) -> bool {
        self.position == 0.0
    }
}

/// By how much a joint comes later than its rate is asked for [s]: the boundary layer of the servo is a lag of 1/κ; the filter of the
/// measured rates, which is late itself, takes its own lag off that, and so do the period in which a rate is measured, one half, and the
/// one for which the plan looks ahead.
///
/// Without this lead the plan runs ahead of the robot, a plan that follows the robot is held back by it, and steps get longer: .70 s
/// instead of .60. The relay has no such lag.
pub fn lag(scene: &ControllerScene, h: f64) -> f64 {
    match scene.switching {
        Switching::Relay => 0.0,
        Switching::BoundaryLayer => (1.0 / scene.switch_rate - 1.0 / (TAU * scene.rate_filter_hz) - 1.5 * h).max(0.0),
    }
}

impl GaitModel {
    /// Corrects the plan by the measured centre of gravity. Under the paper's sagittal rule (42) axis 1 is left alone: mirrored about the
    /// centre of gravity, the foot lands moving, and what that does to the measured speed fells the robot.
    pub(super) fn observe(&self, state: &mut GaitState, task: &Task) {
        let axes = match self.scene.sagittal {
            Sagittal::FootPlacement => 0..2,
            Sagittal::Energy => 1..2,
        };
        for k in axes {
            let axis = &mut state.com[k];
            let innovation = task.x[k] - axis.x;
            axis.x += self.observer.position * innovation;
            axis.v += self.observer.rate * innovation;
        }
    }
}
