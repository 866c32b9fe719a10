//! Claims about the commands that send requests, their refusals, and the requests in the results of a run.

use crate::live::{biped, eventually};
use crate::walking;
use messages::port::{Action, Contract, GaitRequest, Pace, PlantPort, PortError, Verdict, ask};
use messages::scene::Scene;
use messages::session::Session;
use serde_json::Value;
use std::path::PathBuf;
use std::process::Output;

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
        ("push 0.1,0,0", "run; trunk gets 0.1,0,0 N·s"),
        ("set --speed 0.1", "set"),
        ("set --period 0.65", "set"),
        ("set --speed -0.1 --period 0.6", "set"),
        ("set --speed -.05", "set"),
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
    assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    let Output { status, stderr, .. } =
        biped(&["pause", "--session", session.name()]).output().expect("the program runs");
    let errors = String::from_utf8_lossy(&stderr);
    assert_eq!(status.code(), Some(3), "{errors}");
    assert!(errors.contains("no session") && errors.contains(session.name()), "{errors}");
    let output = biped(&["push", "0,1,0", "--body", "trunk", "--session", session.name()]).output().expect("it runs");
    assert!(output.status.code() == Some(3) && String::from_utf8_lossy(&output.stderr).contains("no session"));
    for bad in [&["push", "1,2"][..], &["set"], &["step", "many"], &["set", "--speed", "fast"]] {
        assert_eq!(biped(bad).output().expect("the program runs").status.code(), Some(2), "{bad:?}");
    }
}

/// The paper's trunk is body 4. Other robots have other numbers, or fewer bodies.
#[test]
fn a_push_without_a_body_pushes_the_base_of_the_scene() {
    let session = Session::unique();
    let name = session.name();
    let settings = ["--realtime", "--quiet", "--set", "duration=600", "--set", "bodies.0.name=only", "--session", name];
    let mut run = biped(&[&["run", "slide"][..], &settings].concat()).spawn().expect("the program starts");
    let mut said = String::new();
    eventually("an answer", || {
        let Output { status, stdout, stderr } =
            biped(&["push", "0,0.1,0", "--session", name]).output().expect("the program runs");
        said = String::from_utf8_lossy(&[stdout, stderr].concat()).into();
        status.code() != Some(3) && !said.contains("published no scene") // not yet
    });
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(run.id() as i32), nix::sys::signal::Signal::SIGTERM)
        .expect("our own child");
    run.wait().expect("our own child");
    assert!(said.contains("only gets 0,0.1,0 N·s"), "{said}");
}

#[test]
fn a_refused_request_names_the_allowed_values() {
    let walk = walking("refuses", &[]);
    for (command, words) in [
        (&["push", "0,1,0", "--body", "torso"][..], "the scene has no body `torso`; its bodies are "),
        (&["push", "0,1,0", "--body", "99"], "no body `99`; its bodies are left foot"),
        (&["push", "1001,0,0"], "from -1000 to 1000 N·s"),
        (&["push", "nan,0,0"], "invalid value 'nan,0,0' for '<IMPULSE>': three finite numbers"),
        (&["push", "0,1,0", "--duration", "inf"], "invalid value 'inf' for '--duration <DURATION>': a finite number"),
        (&["set", "--speed", "nan"], "invalid value 'nan' for '--speed <SPEED>': a finite number"),
        (&["set", "--period=1e999"], "invalid value '1e999' for '--period <PERIOD>': a finite number"),
        (&["push", "0,1,0", "--duration", "61"], "greater than 0 and at most 60 s"),
        (&["push", "0,1,0", "--duration", "0"], "greater than 0 and at most 60 s"),
        (&["set", "--speed", "99"], "m"),
    ] {
        let output =
            biped(&[command, &["--session", walk.session.name()]].concat()).output().expect("the program runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(words), "{command:?}: {errors}");
    }
    let not_finite = Action::Push { body: 4, impulse: [f64::NAN, 0.0, 0.0], duration: 0.05 };
    assert_ne!(walk.ask(not_finite).verdict, Verdict::Done as u64, "other programs can send it");
    walk.end();
}

/// The launcher of `biped set` knows the scene, and not the set-points that the controller has now.
#[test]
fn a_refused_set_point_is_named_without_those_of_the_scene() {
    let walk = walking("now", &[]);
    let set = |arguments: &[&str]| {
        let all = [&["set"], arguments, &["--session", walk.session.name()]].concat();
        let Output { status, stderr, .. } = biped(&all).output().expect("the program runs");
        (status.code(), String::from_utf8_lossy(&stderr).into_owned())
    };
    assert_eq!(set(&["--speed", "-0.3"]).0, Some(0));
    let step = "a step, half a period times the speed, is at most 0.25 m, so";
    for (arguments, words) in [
        (&["--period", "5"][..], "controller.period = 5 s is out of range: it must be 0.3 to 2 s\n".to_string()),
        (
            &["--period", "1.9"],
            format!(
                "1.9 s is out of range at the present speed: {step} with this period the speed must be -0.263 to 0.263 m/s\n"
            ),
        ),
        (
            &["--speed", "0.9"],
            format!(
                "0.9 m/s is out of range at the present period: {step} with this speed the period must be 0.3 to 0.555 s\n"
            ),
        ),
        (&["--speed", "99"], format!("99 m/s is out of range: {step} it must be -1.66 to 1.66 m/s\n")),
        (&["--speed", "0.9", "--period", "1"], "controller.period = 1 s and controller.speed = 0.9 m/s are out".into()),
    ] {
        let (code, errors) = set(arguments);
        assert!(code == Some(2) && errors.contains(&words), "{arguments:?}: {errors}");
    }
    walk.end();
}

#[test]
fn a_robot_that_stands_or_stops_refuses_set_points_with_the_reason() {
    for (setting, words) in [
        ("controller.gait=\"stand\"", "controller.gait = \"stand\": a robot that stands has no period and speed"),
        ("controller.stop_time=0", "the walk ends at t = 0 s, so another period or speed has no effect"),
    ] {
        let walk = walking("stands", &["--set", setting]);
        let arguments = ["set", "--speed", "0.1", "--session", walk.session.name()];
        let output = biped(&arguments).output().expect("the program runs");
        let errors = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && errors.contains(words), "{setting}: {errors}");
        walk.end();
    }
}

#[test]
fn requests_to_a_run_are_in_its_summary() {
    let folder = std::env::temp_dir().join(format!("biped-test-asked-{}", std::process::id()));
    let out = folder.to_string_lossy().into_owned();
    // ten times slower than real time, so that no scheduler delays the controller by a whole period
    let walk = walking("asked", &["--speed", "0.1", "--set", "duration=0.4", "--out", &out]);
    let push = Action::Push { body: 4, impulse: [0.0, 0.5, 0.0], duration: 0.05 };
    let refused = Action::Push { body: 99, impulse: [0.0, 0.5, 0.0], duration: 0.05 };
    let set = Action::Gait(GaitRequest::Set { period: None, speed: Some(0.1) });
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
        let time = reply.stamp.time();
        assert!((one["time_s"].as_f64().expect("a time") - time).abs() < 1e-9, "{one} at {time}");
    }
    assert!(table.contains("requests "), "{table}");
}

#[test]
fn a_plant_without_a_controller_serves_requests_and_refuses_set_points() {
    let session = Session::named(&format!("test-{}-alone", std::process::id())).expect("a good name");
    let scene = Scene { duration: 1.0, ..Scene::default() };
    let port = PlantPort::open(&session, &Contract::of(&scene, Pace::Lockstep)).expect("plant");
    let set = Action::Gait(GaitRequest::Set { period: None, speed: Some(0.1) });
    assert!(matches!(ask(&session, set), Err(PortError::Absent { role: "controller", .. })));
    drop(port);
}
