//! Results of `biped_wait`, and the state of a session for a controller.

use std::ffi::c_int;

/// Result of `biped_wait`: the plant's goodbye, which needs no answer.
pub const BIPED_GOODBYE: c_int = 0;
/// Result of `biped_wait`: a new reading of the encoders, which needs torques as an answer.
pub const BIPED_TICK: c_int = 1;
/// Result of `biped_wait`: as BIPED_TICK, for the first reading of a run. The controller must start from its initial state.
pub const BIPED_BEGIN: c_int = 2;

/// State of the session, and the data of the robot that a controller needs.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ControllerStatus {
    /// Number of the plant's run; 0 before the first reading of the encoders.
    pub run: u64,
    /// Number of the newest reading in that run, from 1.
    pub seq: u64,
    /// Simulated time of that reading [s].
    pub time: f64,
    /// Control rate [Hz].
    pub rate: f64,
    /// Angle of one encoder count [rad].
    pub count: f64,
    /// Torque limit of the drives [N·m].
    pub torque_limit: f64,
    /// Joint angles at time zero [rad].
    pub start: [f64; 8],
}
