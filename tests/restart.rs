//! Claims about a controller that is restarted within a step: it has only the encoders, and the robot stays up.

#![expect(clippy::expect_used, reason = "a test may panic")]

#[path = "common/live.rs"]
mod live;

use controller::Controller;
use live::Running;
use messages::port::{Action, GaitRequest, Verdict};
use messages::scene::Scene;
use messages::wire::{Command, Stamp, Stamped};
use nix::sys::signal::Signal;
use plant::process::{ExchangeOutcome, drive};
use plant::{PlantError, Simulation};

/// Lowest height of the trunk of a walking robot [m].
const MIN_HEIGHT: f64 = 0.5;
/// Time over which the speed is averaged: three periods of the gait, because the speed varies within a period [s].
const SPEED_WINDOW: f64 = 1.8;

fn walk(duration: f64) -> Scene {
    walk_until(f64::INFINITY, duration)
}

/// A walk that stops at `stop` [s].
fn walk_until(stop: f64, duration: f64) -> Scene {
    let mut settings = vec![format!("duration={duration}")];
    if stop.is_finite() {
        settings.push(format!("controller.stop_time={stop}"));
    }
    messages::load::load("walk", &settings, messages::load::SCENES).expect("the walk")
}

/// Lowest height of the trunk [m] and final speed [m/s] of a walk. The controller is replaced by a new one before each control period for which
/// `is_replaced` is true.
fn walk_with(scene: &Scene, mut is_replaced: impl FnMut(u64) -> bool) -> (f64, f64) {
    let mut controller = Controller::new(scene).expect("a controller");
    let mut simulation = Simulation::new(scene, 1, 1).expect("a plant");
    let (mut lowest, mut from) = (f64::INFINITY, 0.0);
    let mut epoch = 1;
    // an error after a fall is a consequence of the fall
    let _ = drive::<PlantError>(&mut simulation, |simulation, sensors, _| {
        let truth = simulation.truth();
        lowest = lowest.min(truth.base_position[2]);
        let time = sensors.stamp.time();
        if time <= scene.duration - SPEED_WINDOW {
            from = truth.base_position[0];
        }
        if is_replaced(sensors.stamp.seq) {
            controller = Controller::new(scene).expect("a controller");
            controller.begin_at(time);
            epoch += 1;
        }
        let torques = controller.tick(&sensors.encoders).unwrap_or_default(); // after a fall there may be no solution
        let stamp = Stamp { ack: sensors.stamp.seq, epoch, ..sensors.stamp };
        simulation.receive(&Command { stamp, torques, ..Command::default() }.sealed());
        Ok(ExchangeOutcome::Advance { late_ns: 0 })
    });
    (lowest, (simulation.truth().base_position[0] - from) / SPEED_WINDOW)
}

#[test]
fn a_controller_restarted_at_any_moment_of_the_walk_continues_the_walk() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let scene = walk(7.0);
    for _ in 0..40 {
        let when = random.u64(2000..4000);
        let (lowest, speed) = walk_with(&scene, |seq| seq == when);
        assert!(lowest > MIN_HEIGHT && speed > 0.19, "restarted in period {when}: trunk at {lowest} m, {speed} m/s");
    }
}

#[test]
fn a_controller_restarted_during_the_first_steps_still_reaches_a_walk() {
    let scene = walk(7.0);
    for when in (2..2000).step_by(200) {
        let (lowest, speed) = walk_with(&scene, |seq| seq == when);
        assert!(lowest > MIN_HEIGHT && speed > 0.15, "restarted in period {when}: trunk at {lowest} m, {speed} m/s");
    }
}

/// It bears restarts every 30 ms. More frequent ones keep it from its walk: the feedback of a restarted controller begins anew.
#[test]
fn the_robot_walks_with_a_controller_restarted_every_30_ms_and_hardly_with_one_restarted_every_20_ms() {
    let scene = walk(8.0);
    let living = |periods: u64| {
        let ends =
            [0, 1, 2, 3, 4, 5].map(|k| walk_with(&scene, |seq| seq > 2000 + 31 * k && (seq + 7 * k) % periods == 0));
        println!("every {periods} ms: {ends:.2?}");
        ends
    };
    let walks = |(lowest, speed): &&(f64, f64)| *lowest > MIN_HEIGHT && *speed > 0.19;
    for periods in [30, 50, 200] {
        assert_eq!(living(periods).iter().filter(walks).count(), 6, "restarted every {periods} ms");
    }
    for periods in [2, 8, 20] {
        assert!(living(periods).iter().filter(walks).count() < 3, "restarted every {periods} ms it walks");
    }
}

/// The launcher knows them and passes them on. Otherwise the robot would walk at the speed of the scene again.
#[test]
fn a_controller_that_restarts_or_takes_over_gets_the_set_points_of_the_run() {
    for (name, settings) in [("set-respawn", ["--respawn", "1"]), ("set-swap", ["--swap", "20=biped controller"])] {
        let mut walk = Running::start(name, &[&settings[..], &["--set", "duration=100000"]].concat());
        walk.until("walking", |truth| truth.telemetry.steps > 5);
        let reply = walk.ask(Action::Gait(GaitRequest::Set { period: None, speed: Some(0.1) }));
        assert_eq!(reply.verdict, Verdict::Done as u64);
        let epoch = walk.latest.command.epoch;
        if settings[0] == "--respawn" {
            walk.signal("controller", Signal::SIGKILL);
        }
        let new = walk.until("another controller", |truth| ![0, epoch].contains(&truth.command.epoch));
        let from = new.stamp.time();
        let [near, far] = [10.0, 20.0].map(|time| {
            let later = walk.until("a walk", |truth| truth.stamp.time() > from + time);
            later.base_position[0]
        });
        let speed = (far - near) / 10.0;
        assert!((0.08..0.12).contains(&speed), "{name}: {speed} m/s");
        walk.end();
    }
}

/// The same for a request to stop, which is passed on while the robot comes to rest and when it rests.
#[test]
fn a_controller_that_restarts_or_takes_over_ends_the_walk_that_had_to_end() {
    for (name, settings) in [("stop-respawn", ["--respawn", "9"]), ("stop-swap", ["--swap", "12=biped controller"])] {
        let mut walk = Running::start(name, &[&settings[..], &["--set", "duration=100000"]].concat());
        walk.until("ten seconds", |truth| truth.telemetry.steps > 5 && truth.stamp.time() > 10.0);
        assert_eq!(walk.ask(Action::Gait(GaitRequest::Stop)).verdict, Verdict::Done as u64);
        let mut from = walk.latest.stamp.time();
        for wait in [0.1, 0.3, 4.0] {
            let epoch = walk.latest.command.epoch;
            if settings[0] == "--respawn" {
                walk.until("a moment", |truth| truth.stamp.time() > from + wait);
                walk.signal("controller", Signal::SIGKILL);
            }
            from = walk.until("another controller", |truth| ![0, epoch].contains(&truth.command.epoch)).stamp.time();
            if settings[0] == "--swap" {
                break;
            }
        }
        let [near, far] = [5.0, 10.0].map(|time| walk.until("a rest", |truth| truth.stamp.time() > from + time));
        let moved = far.base_position[0] - near.base_position[0];
        assert!(far.base_position[2] > MIN_HEIGHT && moved.abs() < 1e-3, "{name}: {moved} m");
        walk.end();
    }
}

#[test]
fn a_killed_controller_is_restarted_within_the_step_and_a_killed_plant_starts_a_new_run() {
    for (role, words) in [("controller", "1 controller replaced"), ("plant", "restarting it")] {
        let mut walk = Running::start(role, &["--respawn", "1", "--set", "duration=900"]);
        walk.until("walking", |truth| truth.telemetry.steps > 5);
        walk.stop_observing();
        walk.signal(role, Signal::SIGKILL);
        let (code, out, errors) = walk.wait();
        assert_eq!(code, Some(0), "{role}: {errors}");
        assert!(errors.contains(&format!("the {role} died")) && errors.contains(words), "{errors}");
        assert!(out.contains("no fall") && out.contains("900.00 s"), "{role}: {out}");
    }
}

/// It is replaced during the first step of the stop, during the last one, while the robot comes to rest, and at rest.
#[test]
fn a_controller_that_takes_over_after_the_stop_time_lets_the_robot_stop_and_stand() {
    let scene = walk_until(8.0, 18.0);
    for when in (8000..10_000).step_by(97).chain([8300, 9300, 10_000, 12_000]) {
        let (lowest, speed) = walk_with(&scene, |seq| seq == when);
        assert!(
            lowest > MIN_HEIGHT && speed.abs() < 1e-3,
            "restarted in period {when}: trunk at {lowest} m, {speed} m/s"
        );
    }
    let (lowest, speed) = walk_with(&walk_until(20.0, 18.0), |seq| seq == 9300);
    assert!(lowest > MIN_HEIGHT && speed > 0.19, "it walks until the stop time: trunk at {lowest} m, {speed} m/s");
}

/// A claim about the test helper: a failing test ends its session in any state, also with a stopped process.
#[test]
fn dropping_a_session_in_a_test_ends_all_its_processes() {
    for stopped in [None, Some("plant"), Some("controller")] {
        let mut walk = Running::start("given-up", &["--set", "duration=100000", "--respawn", "3"]);
        walk.until("a walk", |truth| truth.stamp.seq > 100);
        stopped.into_iter().for_each(|role| walk.signal(role, Signal::SIGSTOP));
        let session = walk.session.clone();
        assert!(session.members().len() >= 3, "{:?}", session.members());
        drop(walk);
        assert_eq!((session.members(), session.shm_files()), (vec![], vec![]), "{stopped:?}");
    }
}
