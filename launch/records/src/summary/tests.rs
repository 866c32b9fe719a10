//! Claims about the summary.

use super::*;
use crate::analysis::synthetic::SyntheticWalk;
use messages::scene::Scene;
use messages::wire::Truth;

/// The keys that users' scripts use, in their order.
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
fn all_documented_keys_exist_in_order() {
    let json = summary([]).json();
    let positions: Vec<_> = KEYS.iter().map(|key| json.find(&format!("\n  \"{key}\":"))).collect();
    assert!(positions.iter().all(Option::is_some) && positions.is_sorted(), "{json}");
}

#[test]
fn a_record_with_nan_affects_neither_the_json_syntax_nor_other_values() {
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
fn a_value_that_was_not_measured_is_null() {
    let json: serde_json::Value = serde_json::from_str(&summary([]).json()).unwrap();
    for key in ["fall_time_s", "distance_m", "period_s", "x2_min_m", "zmp_margin_m", "foot_tilt_max_deg"] {
        assert!(json[key].is_null(), "{key}: {}", json[key]);
    }
    assert_eq!(json["fell"], false);
}

/// Quaternion of a turn by `yaw` about z after one by `pitch` about y [rad].
fn turned(yaw: f64, pitch: f64) -> [f64; 4] {
    let ([sz, cz], [sy, cy]) =
        ([f64::sin(0.5 * yaw), f64::cos(0.5 * yaw)], [f64::sin(0.5 * pitch), f64::cos(0.5 * pitch)]);
    [cz * cy, -sz * sy, cz * sy, sz * cy]
}

#[test]
fn a_base_whose_x_axis_is_vertical_has_no_yaw() {
    for yaw in [-3.0, -0.5, 0.0, 2.0] {
        for pitch in [0.0_f64, 60.0, -88.0] {
            let found = super::yaw(turned(yaw, pitch.to_radians()));
            assert!((found - yaw).abs() < 1e-12, "{pitch}: {found} instead of {yaw}");
        }
        for pitch in [89.5_f64, 90.0, -90.0] {
            assert!(super::yaw(turned(yaw, pitch.to_radians())).is_nan(), "{pitch}");
        }
    }
    let walk = SyntheticWalk::new(0.06);
    let lies = |seq| Truth { base_orientation: turned(0.3, 90_f64.to_radians()), ..walk.truth(seq, seq as f64 * 1e-3) };
    let summary = summary((0..100).map(lies));
    let json: serde_json::Value = serde_json::from_str(&summary.json()).unwrap();
    assert!(json["yaw_deg"].is_null() && summary.to_string().contains("no yaw"), "{summary}");
}

/// A body that slides with a constant acceleration, in runs of a few records and of many.
#[test]
fn the_speed_of_what_does_not_step_is_the_mean_over_the_second_half_of_any_run() {
    for (rate, records) in
        [(1.0, 2), (1.0, 4), (10.0, 6), (300.0, 5), (1e3, 10), (1e3, 14), (1e3, 20), (1e3, 777), (1e3, 300_000)]
    {
        let truths = (0..records).map(|seq: u64| {
            let mut truth = Truth { base_orientation: [1.0, 0.0, 0.0, 0.0], ..Truth::default() };
            let time = seq as f64 / rate;
            truth.stamp.sim_ns = (1e9 * time).round() as u64;
            (truth.base_position[0], truth.base_velocity[0]) = (0.5 * time * time, time);
            truth
        });
        let (found, exact) = (summary(truths).speed_mps, 0.75 * (records - 1) as f64 / rate);
        assert!((found / exact - 1.0).abs() < 1e-6, "{records} records at {rate} Hz: {found}, not {exact} m/s");
    }
    assert!(summary([Truth { base_orientation: [1.0, 0.0, 0.0, 0.0], ..Truth::default() }]).speed_mps.is_nan());
}
