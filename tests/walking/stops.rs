//! Claims about the end of a walk.

use crate::common::{run, run_all};

/// Twelve times, evenly spaced over one period of two steps [s].
fn times(first: f64) -> Vec<f64> {
    (0..12).map(|k| first + 0.6 * f64::from(k) / 12.0).collect()
}

/// The step under way at the request is the last, at every speed that is walked. The steps until the request are those of a walk that is
/// cut 6 ms later, because the summary is that of samples 5 ms apart, without the last one.
#[test]
fn the_step_under_way_at_a_request_to_stop_is_the_last() {
    for speed in [0.2, 0.5, 0.7, -0.2, -0.5] {
        let speed = format!("controller.speed={speed}");
        let settings: Vec<[String; 3]> = times(8.0)
            .iter()
            .map(|t| [format!("controller.stop_time={t}"), format!("duration={}", t + 0.006), speed.clone()])
            .collect();
        let cut: Vec<[&str; 2]> = settings.iter().map(|[_, end, speed]| [end.as_str(), speed]).collect();
        let stopped: Vec<[&str; 3]> =
            settings.iter().map(|[stop, _, speed]| [stop.as_str(), "duration=14", speed]).collect();
        let before = run_all("walk", &cut);
        let after = run_all("walk", &stopped);
        for ((before, after), settings) in before.iter().zip(&after).zip(&settings) {
            after.assert_ranges(&[("com_speed_end_mps", 0.0..=1e-3), ("yaw_deg", -5.0..=5.0)]);
            let more = after.number("steps") - before.number("steps");
            assert!((0.0..=1.0).contains(&more), "{settings:?}: {more} steps");
        }
    }
}

/// Falls of a walk that stops at one of two times, under a push at one of twelve times while it comes to rest [N·s].
fn falls([x, y]: [f64; 2], feedback: &str) -> usize {
    let cases: Vec<[String; 3]> = [8.0, 8.15]
        .iter()
        .flat_map(|stop| times(stop + 0.3).into_iter().map(move |push| (*stop, push)))
        .map(|(stop, push)| {
            [
                format!("controller.stop_time={stop}"),
                format!("plant.push_time={push}"),
                format!("plant.push_impulse=[{x:.1}, {y:.1}, 0.0]"),
            ]
        })
        .collect();
    let cases: Vec<Vec<&str>> =
        cases.iter().map(|case| case.iter().map(String::as_str).chain([feedback, "duration=13"]).collect()).collect();
    let runs = run_all("walk", &cases);
    runs.iter().filter(|run| run.fell()).count()
}

/// The negative case: the same law without the measured state.
#[test]
fn a_robot_that_comes_to_rest_survives_pushes_from_four_sides() {
    for push in [[0.0, 3.0], [0.0, -3.0], [5.0, 0.0], [-5.0, 0.0]] {
        assert_eq!(falls(push, "controller.com_feedback=20"), 0, "{push:?} N·s");
    }
    let without = falls([0.0, 3.0], "controller.com_feedback=0");
    assert!(without >= 4, "{without} of 24 fall without feedback");
}

/// Two legs on the ground are a closed chain. With J_n whatever the feet carry (`servo.rs`), one of these stops sways by 12 mm/s at a delay of 3 ms
/// and 8 at 4 ms; 8 and all 14 drive a joint to its limit for a while, and at 5 ms 3 fall. The slower observers of a robot at
/// rest (`RESTING_POLE`) matter for numbers J_n: without them it falls after each stop at 4 ms.
#[test]
fn a_robot_that_has_stopped_stands_still_at_delays_that_a_walk_bears() {
    let cases = |delay: u32| {
        let stop = |step: u32| format!("controller.stop_time={:.1}", 8.0 + 0.3 * f64::from(step));
        (0..14)
            .map(|step| [stop(step), format!("plant.latency_ticks={delay}"), "duration=30".into()])
            .collect::<Vec<[String; 3]>>()
    };
    for delay in [3, 4, 5] {
        let cases = cases(delay);
        for (summary, case) in run_all("walk", &cases).iter().zip(&cases) {
            println!("{case:?}");
            summary.assert_ranges(&[("com_speed_end_mps", 0.0..=1e-3), ("yaw_deg", -5.0..=5.0)]);
        }
    }
    let numbers: Vec<[String; 4]> = cases(4)
        .into_iter()
        .map(|[stop, delay, end]| [stop, delay, end, "controller.nominal_inertia=diagonal".into()])
        .collect();
    for (summary, case) in run_all("walk", &numbers).iter().zip(&numbers) {
        assert!(!summary.fell(), "{case:?}");
    }
}

/// Also before the first step.
#[test]
fn a_robot_that_has_to_stop_before_its_first_step_ends_it() {
    for stop in ["0.2", "0.7", "1.4"] {
        run("walk", &[&format!("controller.stop_time={stop}"), "duration=8"])
            .assert_ranges(&[("com_speed_end_mps", 0.0..=1e-3), ("steps", 0.0..=1.0)]);
    }
}

/// With encoders of 30 bits, quantization is negligible. With the 20 bits of the scene, a dither below one encoder count per control period
/// remains: 2 pi/2^20 rad, 1000 times a second, .27 m below the centre of mass.
#[test]
fn it_stops_and_stands_still_again() {
    let stop = ["controller.stop_time=8", "duration=16"];
    let count = std::f64::consts::TAU / 20f64.exp2() * 1000.0 * 0.27;
    for (bits, still) in [("plant.encoder_bits=30", 1e-6), ("plant.encoder_bits=20", 0.1 * count)] {
        run("walk", &[&stop[..], &[bits]].concat())
            .assert_ranges(&[("com_speed_end_mps", 0.0..=still), ("distance_m", 0.9..=1.6)]);
    }
}

/// Stopping on both feet keeps the soles as flat as walking does.
#[test]
fn it_stops_with_its_soles_flat() {
    run("walk", &["controller.stop_time=8"]).assert_ranges(&[("foot_tilt_max_deg", 0.0..=0.5)]);
}
