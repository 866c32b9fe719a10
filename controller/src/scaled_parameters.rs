//! Times, lengths and speeds of the controller that no scene sets, scaled to the robot by dynamic similarity.
//!
//! The constants below are for the robot of Table 1 and its default gait of .6 s for two steps at .2 m/s. They were chosen by
//! simulation unless a derivation is given. Another robot gets them scaled: lengths by L, times by √L, speeds by √L, where L is
//! the ratio of the heights of the centres of gravity. Accelerations are not scaled, because gravity is the same. The scene's
//! own numbers are scaled when a robot is put into the scene (`messages/src/load/robot.rs`).

use crate::error::ControllerError;
use messages::robot::{Body, SimilarityScale, table_1};
use messages::scene::Gait;

/// Duration of phase *stand*: time for the robot to settle [s].
const STAND: f64 = 0.5;
/// Duration of phase *sway*: moves the centre of gravity by .04 m with at most .4 m/s² (`MINIMUM_JERK_PEAK`) [s].
const SWAY: f64 = 0.8;
/// Duration of phase *lift*: as long as one step of the default gait [s].
const LIFT: f64 = 0.3;
/// Duration of phase *land*, which only names the first part of the time on both feet: as long as *stand* [s].
const LAND: f64 = 0.5;
/// First part of *lift*, in which the weight leaves the swing foot: a third of it [s].
const UNLOAD: f64 = 0.1;
/// Least time between two exchanges: a third of a step of the default gait. It prevents an exchange straight back [s].
const LEAST_STEP: f64 = 0.1;
/// Last part of a step, in which the landing position is fixed: 12 control periods of 1 ms. The coefficients of the quintic grow
/// without bound as the time left goes to zero [s].
const FREEZE: f64 = 0.012;
/// Time in which the weight moves to the new supporting foot after an exchange [s].
const LOADING: f64 = 0.04;
/// Time in which a foot that has landed takes its load [s]. With 20 ms, and a first share of 0.8, the robot fell at the greatest speeds.
const TOUCHDOWN: f64 = 0.01;
/// Shortest horizon of a correction by the ankle; below it the gain 1/(e^(ωt) − 1) grows without bound [s].
const SHORTEST_CORRECTION: f64 = 0.03;
/// Shortest and longest period of two steps that is accepted: half of the default, and about three times [s].
const PERIODS: [f64; 2] = [0.3, 2.0];
/// Excess over the accepted ranges that counts as rounding, because set-points are scaled to other robots [-].
const SET_POINT_ROUNDING: f64 = 1e-9;
/// Largest change of the step length from one step to the next: a quarter of the default step [m].
const STEP_SLEW: f64 = 0.015;
/// The same while the period changes too, so that other set-points are reached in half as many steps [m].
const STEP_SLEW_WITH_PERIOD: f64 = 2.0 * STEP_SLEW;
/// Largest learned correction of the landing position and of the step length: a third of the default step [m].
const MAX_LENGTH_CORRECTION: f64 = 0.02;
/// Largest learned correction of the step duration: a sixth of the default step [s].
const MAX_TIME_CORRECTION: f64 = 0.05;
/// Largest distance of a landing foot from the supporting foot, and so the longest step that is accepted: less than the centre of gravity is high, .27 m [m].
const FARTHEST: f64 = 0.25;
/// Largest acceleration of the swing foot, near the ground, where it may touch too early, and clear of it [m/s²].
const SWING_ACCELERATION: [f64; 2] = [12.0, 18.0];
/// A foot that is higher than this above the other one is in the air: a tenth of the default swing height [m].
const AIRBORNE: f64 = 1e-3;
/// Deviations of ξ_1 between which the limits of a pushed robot widen: those after pushes of 1 and 2.7 N·s [m].
const DEVIATION: [f64; 2] = [0.015, 0.04];
/// Height of the swing foot in the posture for which ω, γ and J_n are computed [m].
const MID_SWING: f64 = 0.02;
/// v_0 of the energy rule: below this speed the input fades, because 1/v of (39) is singular [m/s].
const FADING: f64 = 0.01;
/// Below this speed the paper's sagittal rule starts with the full input: twice [`FADING`] [m/s].
const STARTING: f64 = 2.0 * FADING;
/// A robot with both feet on the ground that sways faster than this is stepping: a third of the lateral speed at an exchange [m/s].
const UNDER_WAY: f64 = 0.05;
/// Largest vertical speed at which the plan raises the centre of gravity [m/s].
const CLIMB: f64 = 0.1;
/// Rate at which the plan's height approaches that of the scene [1/s].
const CLIMB_RATE: f64 = 2.0;
/// Largest joint rate reference where the scene sets none [rad/s].
const RATE_LIMIT: f64 = 12.0;

/// The controller's parameters at the size of its robot.
#[derive(Clone, Copy, Debug)]
pub struct ScaledParameters {
    /// Duration of the phases *stand*, *sway*, *lift* and *land* [s].
    pub phases: [f64; 4],
    /// First part of *lift*, in which the weight leaves the swing foot [s].
    pub unload: f64,
    /// Least time between two exchanges [s].
    pub least_step: f64,
    /// Last part of a step, in which the landing position is fixed [s].
    pub freeze: f64,
    /// Time in which the new supporting foot is loaded [s].
    pub loading: f64,
    /// Time in which a foot that has landed takes its load [s].
    pub touchdown: f64,
    /// Shortest horizon of a correction by the ankle [s].
    pub shortest_correction: f64,
    /// Shortest and longest period of two steps that is accepted [s].
    pub periods: [f64; 2],
    /// Largest change of the step length from one step to the next [m].
    pub step_slew: f64,
    /// The same while the period changes too [m].
    pub step_slew_with_period: f64,
    /// Largest learned correction of the landing position and of the step length [m].
    pub max_length_correction: f64,
    /// Largest learned correction of the step duration [s].
    pub max_time_correction: f64,
    /// Largest distance of a landing foot from the supporting foot [m].
    pub farthest: f64,
    /// Largest acceleration of the swing foot, near the ground and clear of it [m/s²].
    pub swing_acceleration: [f64; 2],
    /// A foot that is higher than this above the other one is in the air [m].
    pub airborne: f64,
    /// Deviations of ξ_1 between which limits widen [m].
    pub deviation: [f64; 2],
    /// Height of the swing foot in the posture of the constants [m].
    pub mid_swing: f64,
    /// v_0 of the energy rule [m/s].
    pub fading: f64,
    /// Below this speed the paper's sagittal rule starts with the full input [m/s].
    pub starting: f64,
    /// A robot with both feet on the ground that sways faster than this is stepping [m/s].
    pub under_way: f64,
    /// Largest vertical speed at which the plan raises the centre of gravity [m/s].
    pub climb: f64,
    /// Rate at which the plan's height approaches that of the scene [1/s].
    pub climb_rate: f64,
    /// Largest joint rate reference where the scene sets none [rad/s].
    pub rate_limit: f64,
    /// Ratio of times to those of Table 1, √L [-].
    pub time: f64,
}

impl ScaledParameters {
    /// Parameters for the robot of these bodies.
    pub fn of(bodies: &[Body]) -> ScaledParameters {
        let scale = SimilarityScale::between(&table_1(), bodies);
        let (t, l, v) = (scale.time(), scale.length, scale.speed());
        ScaledParameters {
            phases: [STAND, SWAY, LIFT, LAND].map(|duration| duration * t),
            unload: UNLOAD * t,
            least_step: LEAST_STEP * t,
            freeze: FREEZE * t,
            loading: LOADING * t,
            touchdown: TOUCHDOWN * t,
            shortest_correction: SHORTEST_CORRECTION * t,
            periods: PERIODS.map(|period| period * t),
            step_slew: STEP_SLEW * l,
            step_slew_with_period: STEP_SLEW_WITH_PERIOD * l,
            max_length_correction: MAX_LENGTH_CORRECTION * l,
            max_time_correction: MAX_TIME_CORRECTION * t,
            farthest: FARTHEST * l,
            swing_acceleration: SWING_ACCELERATION,
            airborne: AIRBORNE * l,
            deviation: DEVIATION.map(|distance| distance * l),
            mid_swing: MID_SWING * l,
            fading: FADING * v,
            starting: STARTING * v,
            under_way: UNDER_WAY * v,
            climb: CLIMB * v,
            climb_rate: CLIMB_RATE / t,
            rate_limit: RATE_LIMIT / t,
            time: t,
        }
    }

    /// Checks period [s] and speed [m/s] of a gait, in a scene or by request. One that stands uses neither.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`] if the period is outside its range, or a step is longer than the foot reaches.
    pub fn check_set_points(&self, gait: Gait, period: f64, speed: f64) -> Result<(), ControllerError> {
        let ([shortest, longest], longest_step) = (self.periods, self.farthest);
        let more = 1.0 + SET_POINT_ROUNDING;
        let is_in_time = (shortest / more..=longest * more).contains(&period);
        match gait == Gait::Stand || is_in_time && (0.5 * period * speed).abs() <= longest_step * more {
            true => Ok(()),
            false => Err(ControllerError::SetPoint { period, speed, shortest, longest, longest_step }),
        }
    }
}
