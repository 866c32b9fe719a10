//! Times, lengths and speeds that were found for the robot of Table 1, carried to another by dynamic similarity.
//!
//! The scene's own numbers are carried over where a robot is put into it (`messages/src/load/robot.rs`); these are those that
//! nobody sets.

use messages::robot::{Body, Scale, table_1};

/// The controller's own choices, at the size of its robot. Accelerations keep to gravity, so they have no scale.
#[derive(Clone, Copy, Debug)]
pub struct ScaledParameters {
    /// Duration of the phases stand, sway, lift and land [s].
    pub phases: [f64; 4],
    /// Part of the lift in which the weight leaves the swing foot [s].
    pub unload: f64,
    /// Least time between two exchanges [s].
    pub least_step: f64,
    /// Time before landing from which the target stays as it is [s].
    pub freeze: f64,
    /// Time in which the new stance foot is loaded [s].
    pub loading: f64,
    /// Shortest time for which a correction by the ankle is reckoned [s].
    pub shortest_correction: f64,
    /// Periods of two steps that a set-point may have [s].
    pub periods: [f64; 2],
    /// Longest step that a set-point may ask for [m].
    pub longest_step: f64,
    /// Change of the step length from one step to the next [m].
    pub step_slew: f64,
    /// Greatest max_length_correction of the landing and of the step's length [m].
    pub max_length_correction: f64,
    /// Greatest max_length_correction of the step's duration [s].
    pub max_time_correction: f64,
    /// Farthest from the supporting foot that the other lands [m].
    pub farthest: f64,
    /// Greatest acceleration of the swing foot: near the ground, which it may touch too early, and clear of it [m/s²].
    pub swing_acceleration: [f64; 2],
    /// A foot this far above the other swings [m].
    pub airborne: f64,
    /// Height of the swing foot amid a step, for the constants [m].
    pub mid_swing: f64,
    /// Below this the 1/v of (39) fades [m/s].
    pub fading: f64,
    /// Slower than this the paper's sagittal rule starts by a kick [m/s].
    pub starting: f64,
    /// With both feet down, a robot that sways faster than this is stepping [m/s].
    pub under_way: f64,
    /// Greatest speed at which the centre of gravity is raised [m/s].
    pub climb: f64,
    /// Rate at which it is [1/s].
    pub climb_rate: f64,
    /// Greatest joint rate that is asked for [rad/s].
    pub rate_limit: f64,
    /// Times over those of Table 1 [-].
    pub time: f64,
}

impl ScaledParameters {
    /// For the robot of these bodies.
    pub fn of(bodies: &[Body]) -> ScaledParameters {
        let scale = Scale::between(&table_1(), bodies);
        let (t, l, v) = (scale.time(), scale.length, scale.speed());
        ScaledParameters {
            phases: [0.5 * t, 0.8 * t, 0.3 * t, 0.5 * t],
            unload: 0.1 * t,
            least_step: 0.1 * t,
            freeze: 0.012 * t,
            loading: 0.04 * t,
            shortest_correction: 0.03 * t,
            periods: [0.3 * t, 2.0 * t],
            longest_step: 0.15 * l,
            step_slew: 0.015 * l,
            max_length_correction: 0.02 * l,
            max_time_correction: 0.05 * t,
            farthest: 0.25 * l,
            swing_acceleration: [12.0, 18.0],
            airborne: 1e-3 * l,
            mid_swing: 0.02 * l,
            fading: 0.01 * v,
            starting: 0.02 * v,
            under_way: 0.05 * v,
            climb: 0.1 * v,
            climb_rate: 2.0 / t,
            rate_limit: 12.0 / t,
            time: t,
        }
    }
}
