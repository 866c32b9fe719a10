//! Limits of the gait that the documents state: speed over period in the guide, and friction over speed beside the paper's margins.

use crate::common::{RunSummary, run_all};

/// Period [s] and the greatest speed in either direction [m/s], as in the guide's table; "all that are accepted" are steps of 0.25 m.
const SPEEDS: [(f64, f64); 14] = [
    (0.3, 0.2),
    (0.35, 0.4),
    (0.4, 0.5),
    (0.45, 0.5),
    (0.5, 0.6),
    (0.55, 0.6),
    (0.6, 0.7),
    (0.8, 0.62),
    (1.0, 0.5),
    (1.2, 0.4),
    (1.4, 0.3),
    (1.6, 0.2),
    (1.8, 0.1),
    (2.0, 0.1),
];

/// The same a tenth of a metre per second faster, where this is accepted and makes it fall in one direction or in both.
const TOO_FAST: [(f64, f64); 8] =
    [(0.3, 0.3), (0.35, 0.5), (0.4, 0.6), (0.45, 0.6), (0.5, 0.7), (0.55, 0.7), (1.6, 0.3), (1.8, 0.2)];

/// Speed [m/s] and the friction from which on it stays up [-].
const FRICTIONS: [(f64, f64); 4] = [(0.3, 0.13), (0.4, 0.23), (0.5, 0.32), (0.6, 0.42)];
/// Differences from that friction: with the first, it falls [-].
const FROM_LEAST: [f64; 6] = [-0.01, 0.0, 0.01, 0.02, 0.03, 0.1];

/// Walks of a minute with these periods and speeds, forward and then backward.
fn walks(set_points: &[(f64, f64)]) -> Vec<RunSummary> {
    let both = set_points.iter().flat_map(|&(period, speed)| [(period, speed), (period, -speed)]);
    let settings = both.map(|(period, speed)| {
        ["duration=60".into(), format!("controller.period={period}"), format!("controller.speed={speed}")]
    });
    run_all("walk", &settings.collect::<Vec<[String; 3]>>())
}

#[test]
fn it_walks_for_a_minute_up_to_the_speeds_of_the_guide_and_falls_beyond() {
    for (summaries, (period, speed)) in walks(&SPEEDS).chunks(2).zip(SPEEDS) {
        for (summary, sign) in summaries.iter().zip([1.0, -1.0]) {
            let [found, yaw] = ["speed_mps", "yaw_deg"].map(|key| summary.number(key));
            let ratio = found / (sign * speed);
            println!("{period} s, {} m/s: {ratio:.3} of the speed, yaw {yaw:.1}°", sign * speed);
            assert!(!summary.fell(), "{period} s, {} m/s", sign * speed);
            assert!((0.9..1.03).contains(&ratio) && yaw.abs() < 10.0, "{period} s, {speed} m/s: {ratio}, {yaw}°");
        }
    }
    for (summaries, (period, speed)) in walks(&TOO_FAST).chunks(2).zip(TOO_FAST) {
        assert!(summaries.iter().any(RunSummary::fell), "{period} s, {speed} m/s: the table may name a greater speed");
    }
}

#[test]
fn faster_walks_need_the_friction_of_the_table() {
    for difference in FROM_LEAST {
        let settings = FRICTIONS.map(|(speed, least)| {
            let friction = format!("plant.friction={:.2}", least + difference);
            ["duration=30".into(), format!("controller.speed={speed}"), friction]
        });
        for (summary, (speed, least)) in run_all("walk", &settings).iter().zip(FRICTIONS) {
            assert_eq!(summary.fell(), difference < 0.0, "{speed} m/s, friction {least} with {difference}");
        }
    }
}
