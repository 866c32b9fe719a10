//! Claims about the control services: a request to a running session has its documented effect, and no other.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod commands;
#[path = "../common/live.rs"]
mod live;
mod memory;

use live::{LONG, Running, biped, eventually};
use messages::port::{Action, GaitRequest, PlantPort, RecorderPort, Verdict, ask};
use messages::session::Session;
use messages::wire::{PHASES, STATES, Truth};
use nix::sys::signal::Signal;
use serde_json::Value;
use std::time::{Duration, Instant};

fn walking(name: &str, extra: &[&str]) -> Running {
    Running::start(name, &[&["--realtime", "--set", "duration=600"], extra].concat())
}

fn seconds(truth: &Truth) -> f64 {
    truth.stamp.time()
}

#[test]
fn time_stops_during_a_pause_and_advances_by_the_requested_periods() {
    let mut walk = walking("pause", &[]);
    walk.until("a start", |truth| seconds(truth) > 0.2);
    let reply = walk.ask(Action::Pause);
    assert_eq!((reply.verdict, STATES[reply.state as usize]), (Verdict::Done as u64, "paused"));
    let held = walk.ask(Action::Pause).stamp;
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(walk.ask(Action::Pause).stamp, held, "time went on");
    walk.ask(Action::Step { periods: 25 });
    let begin = Instant::now();
    while walk.ask(Action::Rearm).stamp.seq < held.seq + 25 {
        assert!(begin.elapsed() < LONG, "the steps did not come");
    }
    std::thread::sleep(Duration::from_millis(100));
    assert_eq!(walk.ask(Action::Pause).stamp.seq, held.seq + 25);
    walk.drain();
    walk.ask(Action::Resume);
    let later = walk.until("going on", |truth| truth.stamp.seq > held.seq + 300);
    assert_eq!(STATES[later.state as usize], "run");
    assert_eq!(later.tally.skipped, walk.latest.tally.skipped, "a pause is no delay");
    walk.end();
}

/// While time stands still, the plant repeats its sensors and the controller its answer. The plant reads only the newest one.
#[test]
fn a_pause_loses_no_command() {
    let mut walk = Running::start("whole", &["--set", "duration=100000"]); // in lockstep
    walk.until("a start", |truth| seconds(truth) > 0.2);
    for _ in 0..3 {
        let held = walk.ask(Action::Pause).stamp;
        std::thread::sleep(Duration::from_nanos(5 * PlantPort::HEARTBEAT_NS));
        walk.ask(Action::Resume);
        let later = walk.until("going on", |truth| truth.stamp.seq > held.seq + 300);
        assert_eq!(later.tally.lost, 0, "nothing is lost in lockstep");
    }
    walk.end();
}

#[test]
fn set_points_from_before_the_first_sensors_hold_in_the_run() {
    let distance = |name: &str, action: Action| {
        let session = Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name");
        let arguments = ["walk", "--session", session.name(), "--set", "duration=6"];
        let mut controller = biped(&[&["controller"], &arguments[..]].concat()).spawn().expect("the program starts");
        eventually("an answer", || ask(&session, action).is_ok_and(|reply| reply.verdict == Verdict::Done as u64));
        let mut plant = biped(&[&["plant"], &arguments[..]].concat()).spawn().expect("the program starts");
        let mut port = None;
        eventually("a plant to listen to", || {
            port = RecorderPort::attach(&session).ok();
            port.is_some()
        });
        let mut port = port.expect("listening");
        let mut x = 0.0;
        eventually("the end of the run", || {
            let has_ended = plant.try_wait().expect("our own child").is_some();
            while let Some(truth) = port.read().expect("reading") {
                x = truth.base_position[0];
            }
            has_ended
        });
        assert!(controller.wait().expect("our own child").success());
        x
    };
    let unchanged = distance("early-unchanged", Action::Gait(GaitRequest::Set { period: None, speed: None }));
    let slower = distance("early-slower", Action::Gait(GaitRequest::Set { period: None, speed: Some(0.1) }));
    println!("{unchanged:.3} m as in the scene, {slower:.3} m at half the speed");
    assert!(unchanged > 0.5 && slower < 0.7 * unchanged, "{unchanged} {slower}"); // it walks from the third second on
}

#[test]
fn a_reset_starts_a_new_run_at_time_zero_that_walks_again() {
    let mut walk = walking("reset", &[]);
    let before = walk.until("a start", |truth| seconds(truth) > 0.5);
    walk.ask(Action::Reset { seed: Some(5) });
    let first = walk.until("another run", |truth| truth.stamp.run != before.stamp.run);
    assert!(first.stamp.seq < 20 && seconds(&first) < 0.05, "{:?}", first.stamp);
    let after = walk.until("walking", |truth| truth.telemetry.steps > 2);
    assert!(after.base_position[2] > 0.2, "it fell");
    walk.end();
}

#[test]
fn a_push_moves_the_robot_by_its_impulse_over_its_mass() {
    let mut walk = walking("push", &["--set", "controller.gait=\"stand\"", "--set", "plant.friction=0.05"]);
    walk.until("standing", |truth| seconds(truth) > 0.2);
    // On nearly frictionless ground the impulse J gives the whole robot the momentum J.
    walk.ask(Action::Push { body: 4, impulse: [2.0, 0.0, 0.0], duration: 0.05 });
    let pushed = seconds(&walk.until("motion", |truth| truth.base_velocity[0].abs() > 1e-2));
    let after = walk.until("the end of the push", |truth| seconds(truth) > pushed + 0.06);
    let mass: f64 = messages::robot::table_1().iter().map(|body| body.mass).sum();
    let speed = 2.0 / mass;
    assert!((after.base_velocity[0] - speed).abs() < 0.5 * speed, "{} m/s, not {speed}", after.base_velocity[0]);
    assert_eq!(
        walk.ask(Action::Push { body: 9, impulse: [0.0; 3], duration: 0.1 }).verdict,
        Verdict::NoSuchBody as u64
    );
    let invalid = Action::Push { body: 4, impulse: [f64::NAN; 3], duration: 0.1 };
    assert_eq!(walk.ask(invalid).verdict, Verdict::OutOfRange as u64);
    walk.end();
}

/// Runs a scene without a controller and pushes it at time zero. Returns `summary.json` and the final position of the base [m].
fn run_with_push(name: &str, extra: &[&str], push: Action) -> (Value, [f64; 3]) {
    let session = Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name");
    let folder = std::env::temp_dir().join(session.name());
    let file = format!("{}/tests/data/{name}.toml", env!("CARGO_MANIFEST_DIR"));
    let arguments = ["run", &file, "--quiet", "--realtime", "--session", session.name(), "--out"];
    let mut launcher = biped(&arguments).arg(&folder).args(extra).spawn().expect("the program starts");
    eventually("an open control service", || {
        assert_eq!(launcher.try_wait().expect("our own child"), None, "{name} ended before the push");
        ask(&session, Action::Pause).is_ok()
    });
    assert_eq!(ask(&session, push).expect("an answer").verdict, Verdict::Done as u64);
    ask(&session, Action::Resume).expect("an answer");
    assert!(launcher.wait().expect("our own child").success(), "{name}");
    let read = |file: &str| std::fs::read_to_string(folder.join(file)).expect("what it wrote");
    let table = read("trajectory.csv");
    let last: Vec<f64> = table.lines().last().expect("rows").split(',').map_while(|cell| cell.parse().ok()).collect();
    let summary = serde_json::from_str(&read("summary.json")).expect("JSON");
    std::fs::remove_dir_all(folder).expect("our own folder");
    (summary, [last[1], last[2], last[3]])
}

/// A push moves a body out of the plane of a planar scene, and onto the ground in a flight scene. So a session simulates the full model, which
/// has the directions and contacts that a push can need.
#[test]
fn a_push_breaks_symmetry_and_can_cause_contact_in_a_flight_scene() {
    for full in [&[][..], &["--full"]] {
        let push = |impulse, duration| Action::Push { body: 0, impulse, duration };
        let extra = |speed| [&["--speed", speed], full].concat();
        let (rest, end) = run_with_push("push-ignored", &extra("5"), push([0.0, 1.0, 0.0], 0.05));
        // acceleration J/(m T) minus friction during the push, then friction alone, for m = 1 kg
        let (mu_g, acceleration) = (0.1 * 9.81, 1.0 / 0.05 - 0.1 * 9.81);
        let distance = 0.5 * acceleration * 0.05_f64.powi(2) + (acceleration * 0.05_f64).powi(2) / (2.0 * mu_g);
        println!("{full:?}: pushed by {} m, in theory {distance} m", end[1]);
        assert!((end[1] - distance).abs() < 2e-3 && end[0].abs() < 1e-9, "{full:?}: {end:?}, not {distance}: {rest}");
        let (landed, end) = run_with_push("push-through-ground", &extra("1"), push([0.0, 0.0, -40.0], 0.001));
        println!("{full:?}: ends at {} m", end[2]);
        assert!((end[2] - 0.05).abs() < 1e-9, "{full:?}: {end:?}: {landed}");
    }
}

#[test]
fn walking_speed_follows_its_set_point_and_bad_set_points_are_refused() {
    let mut walk = walking("set", &["--speed", "3"]);
    walk.until("walking", |truth| truth.telemetry.steps > 4);
    assert_eq!(
        walk.ask(Action::Gait(GaitRequest::Set { period: None, speed: Some(9.0) })).verdict,
        Verdict::OutOfRange as u64
    );
    assert_eq!(
        walk.ask(Action::Gait(GaitRequest::Set { period: None, speed: Some(0.0) })).verdict,
        Verdict::Done as u64
    );
    let now = walk.latest.telemetry.steps;
    let slow = walk.until("a few steps", |truth| truth.telemetry.steps > now + 8);
    let later = walk.until("more steps", |truth| truth.telemetry.steps > now + 12);
    let speed = (later.base_position[0] - slow.base_position[0]) / (seconds(&later) - seconds(&slow));
    assert!(speed.abs() < 0.02, "{speed} m/s in place");
    walk.end();
}

#[test]
fn a_robot_stops_on_request_and_walks_again_after_a_reset() {
    let mut walk = walking("stop", &["--speed", "3"]);
    let name = walk.session.name().to_string();
    let set = |arguments: &[&str]| {
        let all = [&["set", "--session", &name], arguments].concat();
        let output = biped(&all).output().expect("the program runs");
        (output.status.code(), String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned())
    };
    walk.until("walking", |truth| truth.telemetry.steps > 4);
    let (code, said) = set(&["--stop"]);
    assert!(code == Some(0) && said.contains("stop at t "), "{said}");
    let from = walk.until("now", |_| true);
    let rest = walk.until("a rest", |truth| PHASES[truth.telemetry.phase as usize] == "rest");
    assert!(rest.telemetry.steps <= from.telemetry.steps + 1, "{} steps", rest.telemetry.steps);
    let (code, said) = set(&["--speed", "0.1"]);
    let words = "refuses: the walk has ended by request, so another period or speed has no effect before `biped reset`";
    assert!(code == Some(2) && said.contains(words), "{said}");
    assert_eq!(set(&["--stop"]).0, Some(0), "a walk that has ended stays so");
    for bad in [&["--stop", "--speed", "0.1"][..], &["--stop=now"]] {
        assert_eq!(set(bad).0, Some(2), "{bad:?}");
    }
    assert_eq!(walk.ask(Action::Reset { seed: None }).verdict, Verdict::Done as u64);
    walk.until("a new walk", |truth| truth.stamp.run != rest.stamp.run && truth.telemetry.steps > 4);
    walk.end();
}

#[test]
fn drives_that_a_silent_controller_switched_off_stay_off_until_rearmed() {
    let mut stand = walking("rearm", &["--set", "controller.gait=\"stand\""]);
    stand.until("standing", |truth| seconds(truth) > 0.2);
    stand.signal("controller", Signal::SIGSTOP);
    let states = |truth: &Truth| STATES[truth.state as usize];
    stand.until("damping", |truth| states(truth) == "damp");
    let off = stand.until("a fault", |truth| states(truth) == "fault");
    assert!(off.age > 100 && off.torque == [0.0; 8], "{} periods old: {:?}", off.age, off.torque);
    stand.signal("controller", Signal::SIGCONT);
    let heard = stand.until("a command again", |truth| truth.age == 0);
    assert_eq!((states(&heard), heard.torque), ("fault", [0.0; 8]), "a fault is latched");
    assert_eq!(stand.ask(Action::Rearm).verdict, Verdict::Done as u64);
    stand.until("drives on", |truth| states(truth) == "run" && truth.torque != [0.0; 8]);
    stand.end();
}
