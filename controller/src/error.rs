//! Errors of the controller, one sentence each.

use messages::{legible, rounded_down, rounded_up};

/// Errors of [`crate::Controller`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControllerError {
    /// The scene has no `[controller]`.
    #[error("the scene has no [controller] table: there is nothing to control")]
    NoController,
    /// The bodies are not an eight-axis biped.
    #[error("robot: {0}")]
    Robot(String),
    /// The robot cannot reach the height of the centre of gravity that the scene sets.
    #[error(
        "controller.com_height = {} m: no posture reaches it; this robot reaches {} to {} m",
        legible(*height), legible(*low), legible(*high)
    )]
    Height {
        /// Height set by the scene [m].
        height: f64,
        /// Least height with a posture, with three digits [m].
        low: f64,
        /// Greatest height with a posture, with three digits [m].
        high: f64,
    },
    /// Set-points of the gait outside the range of this robot.
    #[error(
        "controller.period = {} s and controller.speed = {} m/s are out of range: the period must be {} to {} s, \
         and a step, half a period times the speed, at most {} m",
        legible(*period), legible(*speed),
        legible(rounded_up(*shortest)), legible(rounded_down(*longest)), legible(rounded_down(*longest_step))
    )]
    SetPoint {
        /// Requested period [s].
        period: f64,
        /// Requested speed [m/s].
        speed: f64,
        /// Shortest period [s].
        shortest: f64,
        /// Longest period [s].
        longest: f64,
        /// Longest step [m].
        longest_step: f64,
    },
    /// A request for one set-point, which does not fit the present value of the other.
    #[error("{0}")]
    Request(String),
    /// New set-points for a robot that only stands.
    #[error("controller.gait = \"stand\": a robot that stands has no period and speed")]
    Standing,
    /// New set-points after the end of the walk [s].
    #[error("the walk ends at t = {} s, so another period or speed has no effect any more", legible(*.0))]
    Stopped(f64),
    /// No joint rates give the task rates.
    #[error("the task Jacobian is singular at t = {time:.3} s: the legs are straight, or an encoder reading is wrong")]
    Singular {
        /// Simulated time [s].
        time: f64,
    },
}

impl ControllerError {
    /// Whether a request is refused only because it would change nothing.
    pub fn is_without_effect(&self) -> bool {
        matches!(self, ControllerError::Standing | ControllerError::Stopped(_))
    }
}
