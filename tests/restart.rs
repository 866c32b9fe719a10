//! Claims about a controller that is started anew amid a step: it sees only encoders, and the robot stays up.

#![expect(clippy::expect_used, reason = "a test may panic")]

#[path = "common/live.rs"]
mod live;

use controller::Controller;
use live::Running;
use messages::scene::Scene;
use messages::wire::{Command, Stamp, Stamped};
use nix::sys::signal::Signal;
use plant::process::{Next, drive};
use plant::{PlantError, Simulation};

/// The trunk of a robot that walks is never lower [m].
const UP: f64 = 0.5;
/// What the speed is measured over: three whole periods of the gait, for the trunk does not go evenly [s].
const LAST: f64 = 1.8;

fn walk(duration: f64) -> Scene {
    let settings = [format!("duration={duration}")];
    messages::load::load("launch/scenes/walk.toml", &settings, &[]).expect("the walk")
}

/// Lowest height of the trunk, and speed over the last three periods of the gait, when the controller is replaced before the periods
/// given.
fn walk_with(scene: &Scene, mut is_replaced: impl FnMut(u64) -> bool) -> (f64, f64) {
    let mut controller = Controller::new(scene).expect("a controller");
    let mut simulation = Simulation::new(scene, 1, 1).expect("a plant");
    let (mut lowest, mut from) = (f64::INFINITY, 0.0);
    let mut epoch = 1;
    // what fails after a fall fails because of it
    let _ = drive::<PlantError>(&mut simulation, |simulation, sensors, _| {
        let truth = simulation.truth();
        lowest = lowest.min(truth.base_position[2]);
        let time = sensors.stamp.sim_ns as f64 * 1e-9;
        if time <= scene.duration - LAST {
            from = truth.base_position[0];
        }
        if is_replaced(sensors.stamp.seq) {
            controller = Controller::new(scene).expect("a controller");
            epoch += 1;
        }
        let torques = controller.tick(&sensors.encoders).unwrap_or_default(); // a heap of legs is no posture
        let stamp = Stamp { ack: sensors.stamp.seq, epoch, ..sensors.stamp };
        simulation.receive(&Command { stamp, torques, ..Command::default() }.sealed());
        Ok(Next::Period { late_ns: 0 })
    });
    (lowest, (simulation.truth().base_position[0] - from) / LAST)
}

#[test]
fn a_controller_restarted_at_any_moment_of_the_walk_goes_on_walking() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let scene = walk(7.0);
    for _ in 0..40 {
        let when = random.u64(2000..4000);
        let (lowest, speed) = walk_with(&scene, |seq| seq == when);
        assert!(lowest > UP && speed > 0.19, "restarted in period {when}: trunk at {lowest} m, {speed} m/s");
    }
}

#[test]
fn a_controller_restarted_while_it_begins_to_walk_walks_later() {
    let scene = walk(7.0);
    for when in (2..2000).step_by(200) {
        let (lowest, speed) = walk_with(&scene, |seq| seq == when);
        assert!(lowest > UP && speed > 0.15, "restarted in period {when}: trunk at {lowest} m, {speed} m/s");
    }
}

#[test]
fn a_robot_whose_controller_lives_for_a_fifth_of_a_second_walks_and_for_a_hundredth_it_falls() {
    let scene = walk(8.0);
    let living = |periods: u64| walk_with(&scene, |seq| seq > 2000 && seq % periods == 0);
    let (lowest, speed) = living(200);
    assert!(lowest > UP && speed > 0.15, "trunk at {lowest} m, {speed} m/s");
    let ends: Vec<_> = (4..=13).step_by(3).map(living).collect();
    println!("{ends:.2?}");
    assert!(ends.iter().all(|(lowest, _)| *lowest < UP), "one stays up: {ends:?}");
}

#[test]
fn a_killed_controller_is_replaced_amid_a_step_and_a_killed_plant_begins_anew() {
    for (role, words) in [("controller", "1 controller replaced"), ("plant", "starting it anew")] {
        let mut walk = Running::start(role, &["--respawn", "1", "--set", "duration=900"]);
        walk.until("walking", |truth| truth.telemetry.steps > 5);
        walk.leave();
        walk.signal(role, Signal::SIGKILL);
        let (code, out, errors) = walk.wait();
        assert_eq!(code, Some(0), "{role}: {errors}");
        assert!(errors.contains(&format!("the {role} died")) && errors.contains(words), "{errors}");
        assert!(out.contains("no fall") && out.contains("900.00 s"), "{role}: {out}");
    }
}

/// A claim about these tests: one that fails amid a session ends it, whatever state that is in.
#[test]
fn a_session_that_a_test_gives_up_ends_with_it() {
    for stopped in [None, Some("plant"), Some("controller")] {
        let mut walk = Running::start("given-up", &["--set", "duration=100000", "--respawn", "3"]);
        walk.until("a walk", |truth| truth.stamp.seq > 100);
        stopped.into_iter().for_each(|role| walk.signal(role, Signal::SIGSTOP));
        let session = walk.session.clone();
        assert!(session.members().len() >= 3, "{:?}", session.members());
        drop(walk);
        assert_eq!((session.members(), session.leftovers()), (vec![], vec![]), "{stopped:?}");
    }
}
