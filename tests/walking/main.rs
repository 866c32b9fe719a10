//! Claims about walking: the values that the summary of a run has to reach.
//!
//! Walks of 600 s are in `biped study endurance`, the whole table of margins in `biped study margins`.

#[path = "../common/mod.rs"]
mod common;
mod hardware;
mod limits;
mod set_points;
mod stops;
mod tiles;

use common::{run, run_all};
use std::f64::consts::FRAC_1_SQRT_2;

const ANY: f64 = f64::INFINITY;

/// The contact residuals of the default law in every step: a solution to rounding error, no energy gain over free motion, and no
/// fallback.
const SOLVED: [(&str, std::ops::RangeInclusive<f64>); 4] = [
    ("signorini_max", 0.0..=1e-10),
    ("natural_map_max", 0.0..=1e-10),
    ("energy_gain_max_j", -ANY..=1e-12),
    ("fallbacks", 0.0..=0.0),
];

#[test]
fn it_steps_in_place_for_a_minute() {
    run("stamp", &[]).assert_ranges(&[
        ("distance_m", -0.2..=0.2),
        ("lateral_max_m", 0.0..=0.2),
        ("period_s", 0.594..=0.606),
        ("period_std_s", 0.0..=0.006),
        ("x2_min_m", 0.0374..=0.0394),
        ("foot_tilt_max_deg", 0.0..=0.5),
        ("steps", 190.0..=200.0),
    ]);
}

/// The summary averages the last 20 periods. In 11 s, these begin after more than 8 steps.
#[test]
fn the_energy_rule_attracts_to_the_orbit_and_nothing_does_without_it() {
    let starts = ["controller.release_x2=0.030", "controller.release_x2=0.044"];
    let settings = |gain| starts.map(|start| ["duration=11", gain, start]);
    let with = settings("controller.energy_gain=4");
    let without = settings("controller.energy_gain=0");
    for summary in run_all("stamp", &with) {
        summary.assert_ranges(&[("period_s", 0.588..=0.612), ("period_std_s", 0.0..=0.006), ("steps", 30.0..=34.0)]);
    }
    for summary in run_all("stamp", &without) {
        let [period, scatter] = ["period_s", "period_std_s"].map(|key| summary.number(key));
        assert!((period / 0.6 - 1.0).abs() > 0.02 || scatter > 0.012, "{period} ± {scatter} s without the rule");
    }
}

#[test]
fn it_walks_two_metres_in_fourteen_seconds() {
    run("walk", &[]).assert_ranges(&[
        ("distance_m", 2.0..=2.8),
        ("speed_mps", 0.19..=0.21),
        ("lateral_m", -0.3..=0.3),
        ("lateral_max_m", 0.0..=0.3),
        ("yaw_deg", -5.0..=5.0),
        ("peak_torque_nm", 1.0..=25.0),
        ("period_s", 0.594..=0.606),
    ]);
}

/// A payload at one side keeps the centre of mass there. Coarse encoders sway the robot after it has stopped, on both feet.
#[test]
fn steps_are_changes_of_the_support_foot_wherever_the_centre_of_mass_is() {
    let payload = ["plant.payload_kg=2", "plant.payload_offset=[0, 0.1, 0.1]"];
    run("walk", &payload).assert_ranges(&[("steps", 41.0..=41.0), ("period_s", 0.594..=0.606)]);
    let stop = ["plant.encoder_bits=15", "controller.stop_time=8", "duration=20"];
    run("walk", &stop).assert_ranges(&[
        ("steps", 20.0..=22.0),
        ("period_s", 0.594..=0.606),
        ("period_std_s", 0.0..=0.006),
    ]);
}

#[test]
fn every_contact_of_the_walk_is_solved() {
    run("walk", &[]).assert_ranges(&SOLVED);
}

#[test]
fn it_walks_twenty_metres_in_110_s() {
    run("walk", &["duration=110"]).assert_ranges(&[
        ("distance_m", 20.0..=24.0),
        ("speed_mps", 0.19..=0.21),
        ("lateral_max_m", 0.0..=0.3),
        ("yaw_deg", -5.0..=5.0),
        ("peak_torque_nm", 1.0..=25.0),
    ]);
}

#[test]
fn it_walks_with_the_sagittal_rule_of_the_paper() {
    run("walk-literal", &[]).assert_ranges(&[("distance_m", 2.0..=4.2), ("speed_mps", 0.17..=0.21)]);
}

/// The paper's integration method, contact law, relay and sagittal rule together, without feed-forward. The paper commands .6 s and .2 m/s, and
/// shows a walk of about 2 m.
#[test]
fn the_literal_equations_of_the_paper_walk() {
    let ranges = [
        ("distance_m", 3.0..=4.0),
        ("speed_mps", 0.19..=0.21),
        ("period_s", 0.597..=0.603),
        ("x2_min_m", 0.038..=0.0395), // equation (40) gives .0388
        ("yaw_deg", -10.0..=10.0),
    ];
    run("paper", &[]).assert_ranges(&ranges);
}

/// The negative case: mirrored foot placement alone is only marginally stable, so without feedback the robot falls and the summary says so.
#[test]
fn without_foot_placement_it_falls() {
    let summary = run("walk", &["controller.foot_placement_gain=0", "controller.com_feedback=0"]);
    let fall = summary.number("fall_time_s");
    assert!(summary.fell() && fall > 1.6, "fell: {}, at {fall} s", summary.fell());
    // The run ends a second after the fall.
    let end = summary.number("duration_s");
    assert!((end - fall - 1.0).abs() < 0.01, "fell at {fall} s, ended at {end} s");
}

/// On lower ground, and as low as it is told to stand.
#[test]
fn a_robot_that_stands_lower_has_not_fallen() {
    let pit = "plant.ground.tiles=[{height = -0.2}]";
    let cases: [&[&str]; 3] = [&[pit], &["controller.com_height=0.19"], &["controller.com_height=0.15"]];
    for summary in run_all("stand", &cases) {
        summary.assert_ranges(&[("duration_s", 10.0..=10.0), ("hop_max_m", -1e-4..=1e-4)]);
    }
}

/// The summary counts the work of a push in the steps in which it acts. Here a control period has two steps. A fifth of the threshold of the
/// warning, 2 %.
#[test]
fn a_push_that_begins_between_control_periods_makes_no_energy() {
    let push =
        |start: &str, duration: &str| [format!("plant.push_time={start}"), format!("plant.push_duration={duration}")];
    let pushes = [("5.0005", "0.01"), ("5", "0.0105"), ("5.0005", "0.0005"), ("5.3", "0.0015")];
    let settings = pushes.map(|(start, duration)| push(start, duration));
    let cases =
        settings.each_ref().map(|[start, duration]| ["duration=6", "plant.push_impulse=[0, 2, 0]", start, duration]);
    for summary in run_all("walk", &cases) {
        let [made, kinetic] = ["energy_made_j", "kinetic_max_j"].map(|key| summary.number(key));
        assert!(made < 0.004 * kinetic, "{made} of {kinetic} J");
    }
}

/// Equation (41) on the robot: after a push, the energy error of its lateral orbit decays at the rate k_E, within 15 %. Without the rule its
/// rate is 0 within 15 % of the lesser k_E. The energy is measured on the robot, not taken from the controller.
#[test]
fn a_pushed_robot_returns_to_its_orbit_at_the_rate_of_equation_41() {
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["study", "attraction", "--quiet"])
        .output()
        .expect("the program starts");
    let table = String::from_utf8_lossy(&output.stdout).into_owned();
    let cells = |name: &str| -> Vec<f64> {
        let row = table.lines().find(|line| line.contains(name)).unwrap_or_else(|| panic!("{name} in {table}"));
        row.split('|').filter_map(|cell| cell.trim().parse().ok()).collect()
    };
    for gain in [4.0, 2.0] {
        let row = cells(&format!("k_E = {gain}, the robot"));
        let rate = row.last().expect("a rate");
        assert!((rate / gain - 1.0).abs() < 0.15, "k_E = {gain}: {row:?}");
    }
    let without = cells("k_E = 0, the robot");
    assert!(without.last().expect("a rate").abs() < 0.15 * 2.0, "{without:?}");
}

/// Eight times of a push, evenly spaced over one period.
fn push_times() -> Vec<String> {
    (0..8).map(|k| format!("plant.push_time={}", 5.02 + 0.6 * f64::from(k) / 8.0)).collect()
}

/// Impulses at the trunk within .05 s. They are half a grid step below the limits of `biped study pushes`, and the phases lie between the phases
/// there. 5 N·s change the speed of the robot by .36 m/s, which is 1.8 times its walking speed. If no limit widens with the deviation
/// (`gait/deviation.rs`), the walk falls under the first of them at five of the eight phases.
#[test]
fn it_survives_pushes_from_four_sides() {
    let impulses = [
        ("walk", [[5.0, 0.0], [-5.0, 0.0], [0.0, 3.0], [0.0, -3.0]]),
        ("stamp", [[4.5, 0.0], [-5.0, 0.0], [0.0, 3.0], [0.0, -3.0]]),
    ];
    for (scene, impulses) in impulses {
        let undisturbed = run(scene, &["duration=9"]);
        for [x, y] in impulses {
            let push = format!("plant.push_impulse=[{x:.1}, {y:.1}, 0.0]");
            let times = push_times();
            let cases: Vec<Vec<&str>> = times.iter().map(|time| vec!["duration=9", &push, time]).collect();
            for summary in run_all(scene, &cases) {
                summary.assert_ranges(&[("steps", 15.0..=40.0)]);
                assert_ne!(summary.hash(), undisturbed.hash(), "the push has to have an effect");
            }
        }
    }
}

/// The negative case: without feedback, the robot falls under pushes that the default survives at every phase.
#[test]
fn without_feedback_in_the_planner_pushes_make_it_fall() {
    let fallen = |feedback: &str| {
        let feedback = format!("controller.com_feedback={feedback}");
        let falls =
            |time: &String| run("walk", &["duration=9", &feedback, "plant.push_impulse=[5.0, 0.0, 0.0]", time]).fell();
        push_times().iter().filter(|time| falls(time)).count()
    };
    let [with, without] = ["20", "0"].map(fallen);
    assert!(with == 0 && without >= 4, "{with} of 8 fall with it, {without} without");
}

/// Forward and backward, up to 2.5 times the speed of the scene. From .4 m/s on the robot falls if the torque limit of the swing foot's
/// ankle does not grow with the acceleration of the foot.
#[test]
fn it_walks_at_other_speeds() {
    let speeds = [
        (-0.5, 0.6),
        (-0.4, 0.6),
        (-0.3, 0.6),
        (-0.1, 0.6),
        (0.1, 0.6),
        (0.3, 0.6),
        (0.4, 0.6),
        (0.5, 0.6),
        (0.6, 0.8),
    ];
    for (speed, period) in speeds {
        let settings = [format!("controller.speed={speed}"), format!("controller.period={period}")];
        let range = if speed > 0.0 { 0.97 * speed..=1.03 * speed } else { 1.03 * speed..=0.97 * speed };
        run("walk", &["duration=60", &settings[0], &settings[1]])
            .assert_ranges(&[("speed_mps", range), ("yaw_deg", -5.0..=5.0)]);
    }
}

/// The walk is straight in any heading: with an initial yaw of 45°, the distances along x and y are equal.
#[test]
fn the_heading_makes_no_difference() {
    let summary = run("walk", &["initial.orientation_deg=[0.0, 0.0, 45.0]"]);
    let way = run("walk", &[]).number("distance_m") * FRAC_1_SQRT_2;
    summary.assert_ranges(&[
        ("distance_m", way - 0.1..=way + 0.1),
        ("lateral_m", way - 0.1..=way + 0.1),
        ("yaw_deg", 44.0..=46.0),
    ]);
}
