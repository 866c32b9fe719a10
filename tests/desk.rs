//! Claims about the control services: a request to a running session has its documented effect, and no other.

#![expect(clippy::expect_used, clippy::unwrap_used, reason = "a test may panic")]

#[path = "common/live.rs"]
mod live;

use live::{LONG, Running, biped, eventually};
use messages::port::{Action, Contract, Pace, PortError, RecorderPort, Verdict, ask};
use messages::scene::Scene;
use messages::session::Session;
use messages::wire::{STATES, Truth};
use nix::sys::signal::Signal;
use serde_json::Value;
use std::process::Output;
use std::time::{Duration, Instant};

fn walking(name: &str, extra: &[&str]) -> Running {
    Running::start(name, &[&["--realtime", "--set", "duration=600"], extra].concat())
}

fn seconds(truth: &Truth) -> f64 {
    truth.stamp.sim_ns as f64 * 1e-9
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
    let unchanged = distance("early-unchanged", Action::Set { period: None, speed: None });
    let slower = distance("early-slower", Action::Set { period: None, speed: Some(0.1) });
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
    assert_eq!(walk.ask(Action::Set { period: None, speed: Some(9.0) }).verdict, Verdict::OutOfRange as u64);
    assert_eq!(walk.ask(Action::Set { period: None, speed: Some(0.0) }).verdict, Verdict::Done as u64);
    let now = walk.latest.telemetry.steps;
    let slow = walk.until("a few steps", |truth| truth.telemetry.steps > now + 8);
    let later = walk.until("more steps", |truth| truth.telemetry.steps > now + 12);
    let speed = (later.base_position[0] - slow.base_position[0]) / (seconds(&later) - seconds(&slow));
    assert!(speed.abs() < 0.02, "{speed} m/s in place");
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

#[test]
fn every_request_command_is_accepted_as_documented() {
    // ten times slower than real time, so that no scheduler delays the controller by a whole period, after which the drives would be in state hold
    let walk = walking("commands", &["--speed", "0.1"]);
    for (command, answer) in [
        ("pause", "paused"),
        ("step 3", "paused"),
        ("resume", "run"),
        ("rearm", "run"),
        (
            "push 0,0.1,-0.1 --body 4 --duration 0.1",
            "run; trunk gets 0,0.1,-0.1 N·s within 0.1 s, which changes the speed of",
        ),
        ("push 0.1,0,0 --body trunk", "run; trunk gets 0.1,0,0 N·s"),
        ("set --speed 0.1", "set"),
        ("set --period 0.65", "set"),
        ("set --speed -0.1 --period 0.6", "set"),
        ("reset 5", "t 0.000 s"),
    ] {
        let mut arguments: Vec<&str> = command.split(' ').collect();
        arguments.extend(["--session", walk.session.name()]);
        let Output { status, stdout, stderr } = biped(&arguments).output().expect("the program runs");
        let said = [stdout, stderr].concat();
        let said = String::from_utf8_lossy(&said);
        assert!(status.success() && said.contains(answer), "{command}: {status}, {said}");
    }
    walk.end();
}

#[test]
fn a_missing_control_service_and_ambiguous_sessions_give_a_sentence_and_an_exit_code() {
    let session = Session::unique();
    assert!(matches!(ask(&session, Action::Pause), Err(PortError::NoSession { .. })));
    assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
    let Output { status, stderr, .. } =
        biped(&["pause", "--session", session.name()]).output().expect("the program runs");
    let errors = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(3), "{errors}");
    assert!(errors.contains("no session") && errors.contains(session.name()), "{errors}");
    for bad in [&["push", "1,2"][..], &["set"], &["step", "many"], &["set", "--speed", "fast"]] {
        assert_eq!(biped(bad).output().expect("the program runs").status.code(), Some(2), "{bad:?}");
    }
}

#[test]
fn a_refused_request_names_what_is_possible() {
    let walk = walking("refuses", &[]);
    for (command, words) in [
        (&["push", "0,1,0", "--body", "torso"][..], "the scene has no body `torso`; its bodies are "),
        (&["push", "0,1,0", "--body", "99"], "no body `99`; its bodies are left foot"),
        (&["push", "nan,0,0"], "from -1000 to 1000 N·s"),
        (&["push", "0,1,0", "--duration", "61"], "from 0 to 60 s"),
        (&["set", "--speed", "99"], "m"),
    ] {
        let output =
            biped(&[command, &["--session", walk.session.name()]].concat()).output().expect("the program runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(words), "{command:?}: {errors}");
    }
    walk.end();
}

#[test]
fn requests_to_a_run_are_in_its_summary() {
    let folder = std::env::temp_dir().join(format!("biped-test-asked-{}", std::process::id()));
    let out = folder.to_string_lossy().into_owned();
    // ten times slower than real time, so that no scheduler delays the controller by a whole period
    let walk = walking("asked", &["--speed", "0.1", "--set", "duration=0.4", "--out", &out]);
    let push = Action::Push { body: 4, impulse: [0.0, 0.5, 0.0], duration: 0.05 };
    let refused = Action::Push { body: 99, impulse: [0.0, 0.5, 0.0], duration: 0.05 };
    let set = Action::Set { period: None, speed: Some(0.1) };
    let replies = [push, refused, set].map(|what| walk.ask(what));
    let (code, table, errors) = walk.wait();
    assert_eq!(code, Some(0), "{errors}");
    let summary = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    std::fs::remove_dir_all(folder).expect("our own folder");
    let summary: Value = serde_json::from_str(&summary).expect("JSON");
    let asked = summary["requests"].as_array().expect("a list");
    // the helper made earlier requests to wait for the control services
    let last = &asked[asked.len() - 3..];
    let of = |key: &str| last.iter().map(|one| one[key].clone()).collect::<Vec<_>>();
    assert_eq!(of("kind"), ["push", "push", "set"]);
    assert_eq!(of("answer"), ["done", "no such body", "done"]);
    assert_eq!(
        (&last[0]["body"], &last[0]["impulse_ns"][1], &last[2]["speed_mps"]),
        (&4.into(), &0.5.into(), &0.1.into())
    );
    for (one, reply) in last.iter().zip(&replies) {
        let time = reply.stamp.sim_ns as f64 * 1e-9;
        assert!((one["time_s"].as_f64().expect("a time") - time).abs() < 1e-9, "{one} at {time}");
    }
    assert!(table.contains("requests "), "{table}");
}

#[test]
fn a_plant_without_a_controller_serves_requests_and_refuses_set_points() {
    let session = Session::named(&format!("test-{}-alone", std::process::id())).expect("a good name");
    let scene = Scene { duration: 1.0, ..Scene::default() };
    let port = messages::port::PlantPort::open(&session, &Contract::of(&scene, Pace::Lockstep)).expect("plant");
    let set = Action::Set { period: None, speed: Some(0.1) };
    assert!(matches!(ask(&session, set), Err(PortError::Absent { role: "controller", .. })));
    drop(port);
}

/// Resident memory of a process, private and shared [kB].
fn memory(number: i32) -> [i64; 2] {
    let status = std::fs::read_to_string(format!("/proc/{number}/status")).unwrap();
    let line = |key| status.lines().find_map(|line| line.strip_prefix(key)).unwrap().trim_end_matches("kB").trim();
    ["RssAnon:", "RssShmem:"].map(|key| line(key).parse().unwrap())
}

/// Shared memory is allocated at the start but becomes resident only on first use, which is when a recorder lags further behind than
/// before.
#[test]
fn memory_does_not_grow_by_resets_and_at_most_once_by_a_slow_recorder() {
    let mut walk = Running::start("memory", &["--set", "duration=100000"]);
    let plant = walk.pid("plant");
    let mut resets = |count| {
        for _ in 0..count {
            let run = walk.ask(Action::Reset { seed: None }).stamp.run;
            walk.until("another walk", |truth| truth.stamp.run == run && truth.stamp.seq > 100);
        }
        let fresh = memory(plant);
        std::thread::sleep(Duration::from_millis(500)); // the plant waits for this recorder
        let lagging = memory(plant);
        walk.drain();
        (fresh, lagging)
    };
    let ((fresh, _), (settled, lagged), (_, again)) = (resets(10), resets(10), resets(60));
    println!(
        "private and shared [kB]: {fresh:?}, after a lag {settled:?}, after a second one {lagged:?}, after 60 resets {again:?}"
    );
    assert!(settled[1] > 1000, "negative control: the buffer of 1024 truths is not visible in {settled:?}");
    assert!((0..2).all(|kind| again[kind] - lagged[kind] < 150), "{lagged:?}, {again:?}");
    walk.end();
}
