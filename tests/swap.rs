//! Claims about hot swaps: controllers in several languages replace each other while the robot stamps and walks.
//!
//! `cargo test --release --test swap lockstep -- --ignored --nocapture`, and the same with `real_time`, performs a hundred
//! swaps in each scene, and prints how often the robot stayed up: docs/RELIABILITY.md.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use common::{assert_refused, fresh_path};
use languages::{compile, python};
use serde_json::Value;
use std::path::PathBuf;
use std::process::Command;

/// Walking controllers: in NumPy; in C, with the torques of `biped_plan`; and the built-in one.
fn successors() -> [String; 3] {
    let python = format!("{} controller/foreign/python/walk.py", python().display());
    let c = compile("cc", "-std=c11", "controller/foreign/c/walk.c");
    [python, c.display().to_string(), "biped controller".into()]
}

/// Runs a scene with swaps at the given times. Returns its summary and standard error.
fn walk(scene: &str, programs: &[String], times: &[f64], arguments: &[&str]) -> (Value, String) {
    let folder = fresh_path("swap");
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(["run", scene, "--quiet", "--out"]).arg(&folder).args(arguments);
    command.env("PYTHONDONTWRITEBYTECODE", "1").env("OPENBLAS_NUM_THREADS", "1");
    for (program, time) in programs.iter().zip(times) {
        command.args(["--swap", &format!("{time}={program}")]);
    }
    let output = command.output().expect("the program starts");
    let summary = std::fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let _ = std::fs::remove_dir_all(folder);
    (serde_json::from_str(&summary).unwrap_or_default(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key} in {summary}"))
}

#[test]
fn the_robot_keeps_walking_through_swaps_from_rust_to_python_to_c_to_rust() {
    let programs = successors();
    let (swapped, printed) = walk("walk", &programs, &[4.0, 6.5, 9.0], &["--set", "duration=12"]);
    assert_eq!(swapped["fell"], false, "{printed}");
    assert!(printed.contains("3 controllers replaced"), "{printed}");
    std::fs::remove_file(&programs[1]).expect("our own file");
    let (undisturbed, _) = walk("walk", &[], &[], &["--set", "duration=12"]);
    let (distance, alone) = (number(&swapped, "distance_m"), number(&undisturbed, "distance_m"));
    assert!((distance / alone - 1.0).abs() < 0.05, "{distance} m beside {alone} m");
}

#[test]
fn the_robot_stops_at_its_stop_time_through_swaps_from_rust_to_python_to_c_to_rust() {
    let (programs, stop) = (successors(), ["--set", "controller.stop_time=8", "--set", "duration=15"]);
    let (swapped, printed) = walk("walk", &programs, &[8.3, 9.3, 10.0], &stop);
    assert_eq!(swapped["fell"], false, "{printed}");
    assert!(printed.contains("3 controllers replaced"), "{printed}");
    std::fs::remove_file(&programs[1]).expect("our own file");
    let (undisturbed, _) = walk("walk", &[], &[], &stop);
    let (distance, alone) = (number(&swapped, "distance_m"), number(&undisturbed, "distance_m"));
    assert!((distance - alone).abs() < 0.2, "a walk to the end is one metre longer: {distance} m beside {alone} m");
}

/// A predecessor does as it is asked when it leaves. Each of these programs is one.
#[test]
fn no_predecessor_calls_its_leaving_an_error() {
    let [python, c, own] = successors();
    let compiled = [
        compile("cc", "-std=c11", "controller/foreign/c/stand.c"),
        compile("c++", "-std=c++17", "controller/foreign/cpp/stand.cpp"),
        PathBuf::from(&c),
    ];
    let [stand, stand_cpp, c] = compiled.each_ref().map(|program| program.display().to_string());
    let programs = [own.clone(), c, stand, stand_cpp, python, own];
    let times: Vec<f64> = (1..=programs.len()).map(|k| 0.5 * k as f64).collect();
    let (summary, printed) = walk("stand", &programs, &times, &["--set", "duration=4"]);
    assert_eq!(summary["takeovers"], programs.len(), "{printed}");
    assert!(!printed.contains("error") && !printed.contains("interrupted"), "{printed}");
    compiled.iter().for_each(|program| std::fs::remove_file(program).expect("our own file"));
}

#[test]
fn a_successor_that_fails_is_named_and_the_run_ends_in_order() {
    let (summary, printed) = walk("stand", &["sh -c 'echo error: no legs >&2; exit 4'".into()], &[1.0], &[]);
    assert!(printed.contains("the controller failed (exit status: 4): no legs"), "{printed}");
    assert_eq!(summary["fell"], false);
}

#[test]
fn a_program_that_does_not_exist_is_refused_before_the_run() {
    for (option, missing, shown) in [
        ("--swap", "3=nosuchprog --fast", "--swap 3=nosuchprog --fast: there is no program `nosuchprog`"),
        ("--controller", "./nosuch.py", "--controller ./nosuch.py: there is no program `./nosuch.py`"),
        ("--plant", "nosuchplant", "--plant nosuchplant: there is no program `nosuchplant`"),
    ] {
        let folder = fresh_path("missing");
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        let output = command.args(["run", "stand", "--quiet", option, missing, "--out"]).arg(&folder).output();
        assert_refused(&output.expect("the program starts"), 2, &[shown, "in PATH"]);
        assert!(!folder.exists());
    }
}

#[test]
fn a_successor_that_exits_before_its_swap_ends_the_run() {
    let (summary, printed) = walk("stand", &["true".into()], &[1.0], &[]);
    assert!(printed.contains("the successor exited before it took over"), "{printed}");
    assert_eq!(summary["fell"], false);
    let (_, printed) = walk("stand", &["sleep 600".into()], &[1.0], &["--patience", "1"]);
    assert!(printed.contains("the successor did not join within 1 s"), "{printed}");
}

#[test]
#[ignore = "minutes: a hundred hand-overs in each scene"]
fn a_hundred_times_in_lockstep() {
    a_hundred_times(&[]);
}

#[test]
#[ignore = "a quarter of an hour: a hundred hand-overs in each scene"]
fn a_hundred_times_in_real_time() {
    a_hundred_times(&["--realtime"]);
}

/// Performs three swaps in each run, at random times, and prints how often the robot stayed up, compared with as many runs without swaps.
fn a_hundred_times(pace: &[&str]) {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let programs = successors();
    let arguments = [pace, &["--set", "duration=11"]].concat();
    for scene in ["walk", "stamp"] {
        let (mut up, mut handed, mut fallen, mut alone) = (0, 0, vec![], 0);
        for _ in 0..34 {
            let times = [3.0, 5.5, 8.0].map(|time| time + 0.6 * random.f64());
            let (summary, printed) = walk(scene, &programs, &times, &arguments);
            let fell = summary["fell"] != false;
            let ended = if fell { number(&summary, "fall_time_s") } else { f64::INFINITY };
            let done = times.iter().filter(|time| **time < ended).count();
            handed += done;
            up += done - usize::from(fell && done > 0);
            if fell {
                fallen.push(format!("at {ended:.2} s after hand-overs at {times:.2?}: {}", printed.trim()));
            }
            alone += usize::from(walk(scene, &[], &[], &arguments).0["fell"] == false);
        }
        println!("{scene} {pace:?}: {up} of {handed} hand-overs left it up; without any, {alone} of 34 runs did");
        fallen.iter().for_each(|printed| println!("  fell {printed}"));
    }
    std::fs::remove_file(&programs[1]).expect("our own file");
}
