//! The run in numbers: `summary.json`, and in `table` what of them is shown.

pub mod table;

use crate::analysis::{RequestRecord, RunAnalysis, TrajectoryRow};
use messages::wire::{REFUSALS, Tally};
use serde::Serialize;
use shared::exit::Failure;
use std::time::Duration;

/// What came out of a run; SI units, degrees where named. What could not be measured is NaN or infinite here and null
/// in JSON.
#[derive(Clone, Debug, Serialize)]
pub struct Summary {
    /// Name of the scene.
    pub scene: String,
    /// Name of the robot.
    pub robot: String,
    /// Whether the trunk came down; always false for robots without two feet.
    pub fell: bool,
    /// When it did [s].
    pub fall_time_s: Option<f64>,
    /// Simulated time [s].
    pub duration_s: f64,
    /// Displacement of the centre of mass along x [m].
    pub distance_m: f64,
    /// Its displacement along y [m].
    pub lateral_m: f64,
    /// Heading of the base at the end [deg].
    pub yaw_deg: f64,
    /// Mean speed along x over the last half of the walk; without steps, of the run [m/s].
    pub speed_mps: f64,
    /// Mean period of two steps over the last 20 [s].
    pub period_s: f64,
    /// Its standard deviation over the same steps [s].
    pub period_std_s: f64,
    /// Least lateral distance of the centre of mass from the support foot, mean of the last 20 steps [m].
    pub x2_min_m: f64,
    /// Exchanges of support.
    pub steps: usize,
    /// Greatest torque of each drive [N·m].
    pub peak_torque_nm: [f64; 8],
    /// Greatest mechanical power of each drive [W].
    pub peak_power_w: [f64; 8],
    /// Greatest tilt of the foot that carries more [deg].
    pub foot_tilt_max_deg: f64,
    /// Least distance of the zero-moment point inside the sole's edge while one foot has carried everything for 40 ms [m].
    pub zmp_margin_m: f64,
    /// Greatest Signorini residual, relative to the step's scale.
    pub signorini_max: f64,
    /// Greatest natural-map residual, relative to the step's scale.
    pub natural_map_max: f64,
    /// Greatest energy after the impulse above that of free motion [J].
    pub energy_gain_max_j: f64,
    /// Steps whose contact problem needed a fallback.
    pub fallbacks: u64,
    /// The most that the energy rose above an earlier one, less the work of drives and of the scene's push: what integration made, or a push
    /// that was asked for [J].
    pub energy_made_j: f64,
    /// The most that it fell below an earlier one before anything touched, where no joint is damped: what integration lost [J].
    pub energy_lost_j: f64,
    /// Greatest kinetic energy, of the drives too [J].
    pub kinetic_max_j: f64,
    /// Hash of every state of the run.
    pub trajectory_hash: String,
    /// Time that the run took [s].
    pub wall_s: f64,
    /// Simulated time per time taken.
    pub realtime_factor: f64,
    /// Processes that simulated: 1 or 2.
    pub processes: u32,
    /// Least x_2 min of all steps [m].
    pub x2_least_m: f64,
    /// Greatest sideways distance of the centre of mass from where it began [m].
    pub lateral_max_m: f64,
    /// Greatest height of the lowest contact point after the first contact [m].
    pub hop_max_m: f64,
    /// Greatest normal force of the ground on the whole robot, mean over a control period [N].
    pub peak_force_n: f64,
    /// Deepest penetration [m].
    pub penetration_max_m: f64,
    /// Greatest angle between friction and the direction opposite to slip [deg].
    pub slip_misalignment_max_deg: f64,
    /// Speed of the centre of mass at the end [m/s].
    pub com_speed_end_mps: f64,
    /// Median time of the plant for one control period [s].
    pub plant_median_s: f64,
    /// Integration steps in one control period.
    pub steps_per_period: u64,
    /// Commands refused by the plant's gate, by reason in the order of the wire's table.
    pub refused: [u64; REFUSALS.len()],
    /// Commands that never came.
    pub commands_lost: u64,
    /// Control periods on torques of an earlier one.
    pub periods_held: u64,
    /// Control periods damped for want of a young command.
    pub periods_damped: u64,
    /// Control periods with the drives off.
    pub periods_faulted: u64,
    /// Control periods that real time was ahead and that were left out.
    pub periods_skipped: u64,
    /// Controllers that another one replaced.
    pub takeovers: u64,
    /// All of that in words, if there is anything.
    #[serde(skip)]
    pub met: String,
    /// What was asked of the run, at most the first thousand; a run that nobody spoke to repeats to the bit.
    pub requests: Vec<RequestRecord>,
    /// The same in words.
    #[serde(skip)]
    pub asked: String,
    /// Records left out because their pose was not finite.
    pub dropped: u64,
    /// What the model has that was simulated, and what the scene's own has if that is larger.
    pub model: String,
    /// Its time over that of the scene's own model, for the first steps of the scene; 1 if it is that one; NaN
    /// where nothing was measured.
    pub model_cost_ratio: f64,
    /// What ended the run before its time.
    pub cut_short_by: Option<&'static str>,
    /// What ended the recording before the run.
    pub recording_ended_by: Option<String>,
    /// Time from the first record to the last, without start and end of the processes [s].
    pub loop_s: f64,
}

/// Steps at the end of the walk that period and x_2 min are averaged over.
const LAST_STEPS: usize = 20;

impl Summary {
    /// Sums up what the analysis heard; `wall` is the time that the run took, zero as `processes` where that is not known.
    pub fn new(scene: &str, analysis: &RunAnalysis, wall: Duration, processes: u32) -> Self {
        let (gait, extrema) = (&analysis.gait, &analysis.extrema);
        let ends = analysis.first.as_ref().zip(analysis.last.as_ref());
        let over = |f: &dyn Fn(&TrajectoryRow, &TrajectoryRow) -> f64| ends.map_or(f64::NAN, |(a, b)| f(a, b));
        let tally = analysis.last.as_ref().map_or_else(Tally::default, |last| last.truth.tally);
        let duration_s = over(&|_, last| last.derived.time);
        let (period_s, period_std_s) = gait.period(LAST_STEPS);
        let energy = &analysis.energy;
        let told = |joules: f64| if joules > energy.rounding() { joules } else { 0.0 };
        Summary {
            scene: scene.into(),
            robot: analysis.robot.name.clone(),
            fell: extrema.fall.is_some(),
            fall_time_s: extrema.fall,
            duration_s,
            distance_m: over(&|first, last| last.derived.com.x - first.derived.com.x),
            lateral_m: over(&|first, last| last.derived.com.y - first.derived.com.y),
            yaw_deg: over(&|_, last| yaw(last.truth.base_orientation).to_degrees()),
            speed_mps: if gait.steps.len() > 2 { gait.speed() } else { speed(analysis) },
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
            energy_made_j: told(energy.made),
            energy_lost_j: told(energy.lost),
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
            met: tally.to_string(),
            requests: analysis.requests.list.clone(),
            asked: analysis.requests.text(),
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

    /// With the size of the simulated model, and its time over that of the scene's own.
    pub fn on(self, model: String, model_cost_ratio: f64) -> Self {
        Summary { model, model_cost_ratio, ..self }
    }

    /// With what ended the run, if it was not the end of the scene.
    pub fn ended(self, failure: Option<&Failure>) -> Self {
        Summary { cut_short_by: failure.and_then(|failure| failure.exit.cause()), ..self }
    }

    /// As JSON, one key per line.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| format!("{{\"error\": \"{error}\"}}")) + "\n"
    }
}

/// Angle about the vertical of an orientation w, x, y, z [rad].
pub fn yaw([w, x, y, z]: [f64; 4]) -> f64 {
    (2.0 * (w * z + x * y)).atan2(1.0 - 2.0 * (y * y + z * z))
}

/// Mean speed along x over the last half of the track, for robots that do not step.
fn speed(analysis: &RunAnalysis) -> f64 {
    let (Some([half, from]), Some([end, to])) = (analysis.track.get(analysis.track.len() / 2), analysis.track.last())
    else {
        return f64::NAN;
    };
    (to - from) / (end - half)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::synthetic::SyntheticWalk;
    use messages::scene::Scene;
    use messages::wire::Truth;

    /// The keys that users' scripts rely on, in their order.
    const KEYS: [&str; 24] = [
        "scene",
        "fell",
        "fall_time_s",
        "duration_s",
        "distance_m",
        "lateral_m",
        "yaw_deg",
        "speed_mps",
        "period_s",
        "period_std_s",
        "x2_min_m",
        "steps",
        "peak_torque_nm",
        "peak_power_w",
        "foot_tilt_max_deg",
        "zmp_margin_m",
        "signorini_max",
        "natural_map_max",
        "energy_gain_max_j",
        "fallbacks",
        "trajectory_hash",
        "wall_s",
        "realtime_factor",
        "processes",
    ];

    pub fn summary(truths: impl IntoIterator<Item = Truth>) -> Summary {
        let mut analysis = RunAnalysis::new(&Scene::default());
        truths.into_iter().for_each(|truth| analysis.push(&truth));
        Summary::new("walk", &analysis, Duration::from_millis(200), 2)
    }

    #[test]
    fn every_promised_key_is_there_and_in_order() {
        let json = summary([]).json();
        let places: Vec<_> = KEYS.iter().map(|key| json.find(&format!("\n  \"{key}\":"))).collect();
        assert!(places.iter().all(Option::is_some) && places.is_sorted(), "{json}");
    }

    #[test]
    fn a_record_that_is_not_a_number_breaks_neither_json_nor_the_rest() {
        let walk = SyntheticWalk::new(0.06);
        let truths = (0..5000).map(|seq| {
            let mut truth = walk.truth(seq, seq as f64 * 1e-3);
            truth.base_position[2] = if seq == 3000 { f64::NAN } else { truth.base_position[2] };
            truth.natural_map = if seq == 3001 { f64::NAN } else { truth.natural_map };
            truth
        });
        let summary = summary(truths);
        let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
        assert_eq!(json["dropped"], 1);
        assert!(json["natural_map_max"].is_null() && json["signorini_max"].is_number());
        assert!((json["period_s"].as_f64().unwrap() - 0.6).abs() < 1e-3);
        assert!(json["trajectory_hash"].as_str().unwrap().len() == 16);
    }

    #[test]
    fn what_was_not_measured_is_null() {
        let json: serde_json::Value = serde_json::from_str(&summary([]).json()).unwrap();
        for key in ["fall_time_s", "distance_m", "period_s", "x2_min_m", "zmp_margin_m", "foot_tilt_max_deg"] {
            assert!(json[key].is_null(), "{key}: {}", json[key]);
        }
        assert_eq!(json["fell"], false);
    }
}
