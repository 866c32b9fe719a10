//! What can be wrong with a controller's input, one sentence each.

/// Errors of [`crate::Controller`].
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ControllerError {
    /// The scene has no `[controller]`.
    #[error("the scene has no [controller] table: there is nothing to control")]
    NoController,
    /// The bodies are not an eight-axis biped.
    #[error("robot: {0}")]
    Robot(String),
    /// The centre of gravity cannot be where the scene wants it.
    #[error("controller.com_height = {height} m: no posture reaches it; try between {low:.2} and {high:.2}")]
    Height {
        /// Height asked for [m].
        height: f64,
        /// Least sensible height [m].
        low: f64,
        /// Greatest sensible height [m].
        high: f64,
    },
    /// Gait set-points that no robot of this kind can follow.
    #[error(
        "a period of {period} s at {speed} m/s cannot be walked: {shortest:.2} to {longest:.2} s and steps up to {longest_step:.3} m can"
    )]
    SetPoint {
        /// Period asked for [s].
        period: f64,
        /// Speed asked for [m/s].
        speed: f64,
        /// Shortest period [s].
        shortest: f64,
        /// Longest period [s].
        longest: f64,
        /// Longest step [m].
        longest_step: f64,
    },
    /// The task cannot be resolved into joint rates.
    #[error("the task Jacobian is singular at t = {time:.3} s: the legs are straight or an encoder reads nonsense")]
    Singular {
        /// Time since the controller began [s].
        time: f64,
    },
}
