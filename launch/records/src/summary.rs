//! Summary of a run: the numbers in `summary.json`, and in [`table`] the lines for the terminal and the page.

pub mod table;

use crate::analysis::{RequestRecord, RunAnalysis, TrackPoint, TrajectoryRow, speed_of_second_half};
use messages::wire::{REFUSALS, Tally};
use serde::Serialize;
use shared::exit::Failure;
use std::time::Duration;

/// Results of a run, in SI units except for angles in degrees where the name says so. A value that could not be measured
/// is NaN or infinite here and null in JSON.
///
/// Extremes of the motion are those of the records, one for each control period, so they depend on the scene's `rate`. Residuals, energy gain
/// of impulses and hash are of every step.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// True if the robot fell. Always false for a robot without two feet.
    pub fell: bool,
    /// Time of the fall [s].
    pub fall_time_s: Option<f64>,
    /// Simulated time [s].
    pub duration_s: f64,
    /// Displacement of the centre of mass along x [m].
    pub distance_m: f64,
    /// Displacement of the centre of mass along y [m].
    pub lateral_m: f64,
    /// Heading of the base's x axis at the end [deg]; NaN if that is vertical.
    pub yaw_deg: f64,
    /// Mean speed along x over the second half of the walk [m/s]. Without steps: over the second half of the run.
    pub speed_mps: f64,
    /// Mean of the last 20 periods of two steps [s].
    pub period_s: f64,
    /// Standard deviation of the same periods [s].
    pub period_std_s: f64,
    /// Least lateral distance of the centre of mass from the support foot in a step, mean of the last 20 steps [m].
    pub x2_min_m: f64,
    /// Number of changes of the support foot. Sway on both feet is none.
    pub steps: usize,
    /// Greatest torque of each drive [N·m].
    pub peak_torque_nm: [f64; 8],
    /// Greatest mechanical power of each drive [W].
    pub peak_power_w: [f64; 8],
    /// Greatest tilt of the foot with the greater load [deg].
    pub foot_tilt_max_deg: f64,
    /// Least distance of the zero-moment point from the edge of the sole, from 40 ms after the start of each single
    /// support [m].
    pub zmp_margin_m: f64,
    /// Greatest Signorini residual, relative to the step's scale.
    pub signorini_max: f64,
    /// Greatest natural-map residual, relative to the step's scale.
    pub natural_map_max: f64,
    /// Greatest energy after the impulse above that of free motion [J].
    pub energy_gain_max_j: f64,
    /// Steps whose contact problem needed a fallback.
    pub fallbacks: u64,
    /// Greatest increase of the energy balance, that is of the energy minus the work of drives and of the scene's push [J].
    /// It is caused by integration errors or by a push that a user requested.
    pub energy_made_j: f64,
    /// Greatest decrease of the energy balance before the first contact, if no joint is damped: integration error [J].
    pub energy_lost_j: f64,
    /// Greatest kinetic energy, including that of the drives [J].
    pub kinetic_max_j: f64,
    /// Hash of all states of the run.
    pub trajectory_hash: String,
    /// Wall-clock time of the run [s].
    pub wall_s: f64,
    /// Simulated time per wall-clock time.
    pub realtime_factor: f64,
    /// Number of processes that simulated: 1 or 2.
    pub processes: u32,
    /// Least x_2 min of all steps [m].
    pub x2_least_m: f64,
    /// Greatest lateral distance of the centre of mass from its initial position [m].
    pub lateral_max_m: f64,
    /// Greatest height of the nearest contact point above the ground, after the first contact [m].
    pub hop_max_m: f64,
    /// Greatest normal force of the ground on the whole robot, mean over a control period [N].
    pub peak_force_n: f64,
    /// Deepest penetration [m].
    pub penetration_max_m: f64,
    /// Greatest angle between friction and the direction opposite to slip [deg].
    pub slip_misalignment_max_deg: f64,
    /// Speed of the centre of mass at the end [m/s].
    pub com_speed_end_mps: f64,
    /// Median computing time of the plant per control period [s].
    pub plant_median_s: f64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    /// Commands that the plant refused, by reason, in the order of [`REFUSALS`].
    pub refused: [u64; REFUSALS.len()],
    /// Commands that were lost.
    pub commands_lost: u64,
    /// Control periods with the torques of an earlier period.
    pub periods_held: u64,
    /// Control periods with damped joints, because the latest command was too old.
    pub periods_damped: u64,
    /// Control periods with the drives off.
    pub periods_faulted: u64,
    /// Control periods that were skipped, because the simulation was behind real time.
    pub periods_skipped: u64,
    /// Controllers that another one replaced.
    pub takeovers: u64,
    /// Text of the counters above. Empty if all are zero.
    #[serde(skip)]
    pub link_text: String,
    /// Answered requests, at most the first thousand. A run without requests is reproducible bit for bit.
    pub requests: Vec<RequestRecord>,
    /// Text of the requests.
    #[serde(skip)]
    pub requests_text: String,
    /// Records that were skipped, because their pose was not finite.
    pub dropped: u64,
    /// Size of the simulated model, and that of the scene's full model if it is larger.
    pub model: String,
    /// Computing time of the simulated model relative to the scene's full model, over the first steps of the scene. 1 if
    /// both are the same, NaN if not measured.
    pub model_cost_ratio: f64,
    /// Cause of an early end of the run.
    pub cut_short_by: Option<&'static str>,
    /// Cause of an early end of the recording.
    pub recording_ended_by: Option<String>,
    /// Wall-clock time from the first record to the last, without start and end of the processes [s].
    pub loop_s: f64,
}

/// Number of steps at the end of a walk over which period and x_2 min are averaged.
const LAST_STEPS: usize = 20;

impl Summary {
    /// Summarises an analysis. `wall` is the wall-clock time of the run. It is zero if unknown, and so is `processes`.
    pub fn new(scene: &str, analysis: &RunAnalysis, wall: Duration, processes: u32) -> Self {
        let (gait, extrema) = (&analysis.gait, &analysis.extrema);
        let ends = analysis.first.as_ref().zip(analysis.last.as_ref());
        let over = |f: &dyn Fn(&TrajectoryRow, &TrajectoryRow) -> f64| ends.map_or(f64::NAN, |(a, b)| f(a, b));
        let tally = analysis.last.as_ref().map_or_else(Tally::default, |last| last.truth.tally);
        let duration_s = over(&|_, last| last.derived.time);
        let (period_s, period_std_s) = gait.period(LAST_STEPS);
        let slide = over(&|_, last| speed_of_second_half(&analysis.track, &TrackPoint::new(&last.derived)));
        let energy = &analysis.energy;
        let above_rounding = |joules: f64| if joules > energy.rounding() { joules } else { 0.0 };
        Summary {
            scene: scene.into(),
            robot: analysis.robot.name.clone(),
            fell: extrema.fall.is_some(),
            fall_time_s: extrema.fall,
            duration_s,
            distance_m: over(&|first, last| last.derived.com.x - first.derived.com.x),
            lateral_m: over(&|first, last| last.derived.com.y - first.derived.com.y),
            yaw_deg: over(&|_, last| yaw(last.truth.base_orientation).to_degrees()),
            speed_mps: if gait.steps.len() > 2 { gait.speed() } else { slide },
            period_s,
            period_std_s,
            x2_min_m: gait.x2_min(LAST_STEPS),
            steps: gait.steps.len(),
            peak_torque_nm: extrema.torque,
            peak_power_w: extrema.power,
            foot_tilt_max_deg: extrema.foot_tilt.to_degrees(),
            zmp_margin_m: extrema.zmp_margin,
            signorini_max: extrema.signorini,
            natural_map_max: extrema.natural_map,
            energy_gain_max_j: extrema.energy_gain,
            energy_made_j: above_rounding(energy.made),
            energy_lost_j: above_rounding(energy.lost),
            kinetic_max_j: energy.kinetic,
            fallbacks: analysis.last.as_ref().map_or(0, |last| last.truth.fallbacks),
            trajectory_hash: format!("{:016x}", analysis.last.as_ref().map_or(0, |last| last.truth.hash)),
            wall_s: wall.as_secs_f64(),
            realtime_factor: duration_s / wall.as_secs_f64(),
            processes,
            x2_least_m: gait.complete().iter().map(|step| step.x2_min).fold(f64::INFINITY, f64::min),
            lateral_max_m: extrema.drift,
            hop_max_m: extrema.hop,
            peak_force_n: extrema.force,
            penetration_max_m: extrema.penetration,
            slip_misalignment_max_deg: extrema.slip_misalignment.to_degrees(),
            com_speed_end_mps: over(&|_, last| last.derived.com_velocity.norm()),
            plant_median_s: analysis.distributions.plant.quantile(0.5) * 1e-9,
            refused: tally.refused,
            commands_lost: tally.lost,
            periods_held: tally.held,
            periods_damped: tally.damped,
            periods_faulted: tally.faulted,
            periods_skipped: tally.skipped,
            takeovers: tally.takeovers,
            link_text: tally.to_string(),
            requests: analysis.requests.list.clone(),
            requests_text: analysis.requests.text(&analysis.robot.bodies),
            steps_per_period: analysis.steps_per_period,
            dropped: analysis.dropped,
            model: String::new(),
            model_cost_ratio: f64::NAN,
            cut_short_by: None,
            recording_ended_by: None,
            loop_s: over(&|first, last| {
                last.truth.stamp.mono_ns.saturating_sub(first.truth.stamp.mono_ns) as f64 * 1e-9
            }),
        }
    }

    /// Adds the size of the simulated model and its relative computing time.
    pub fn with_model(self, model: String, model_cost_ratio: f64) -> Self {
        Summary { model, model_cost_ratio, ..self }
    }

    /// Adds the cause of an early end.
    pub fn with_end(self, failure: Option<&Failure>) -> Self {
        Summary { cut_short_by: failure.and_then(|failure| failure.exit.cause()), ..self }
    }

    /// The summary as JSON, one key per line.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}")) + "\n"
    }
}

/// The x axis of a base has no heading if its part along the ground is less than this [-]: it is vertical up to a degree, and rounding would decide.
const LEAST_HEADING: f64 = 0.0175;

/// Yaw angle of a quaternion w, x, y, z [rad]: the heading of its x axis, NaN if that is vertical.
pub fn yaw([w, x, y, z]: [f64; 4]) -> f64 {
    let [along, across] = [1.0 - 2.0 * (y * y + z * z), 2.0 * (w * z + x * y)];
    if along.hypot(across) < LEAST_HEADING { f64::NAN } else { across.atan2(along) }
}

#[cfg(test)]
mod tests;
