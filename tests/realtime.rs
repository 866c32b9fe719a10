//! Claims about asking for real time: every step is told, and a refusal says what would lift it.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::{Command, Output, Stdio};

/// Exit code and what was written to standard error.
fn told(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    let Output { status, stderr, .. } =
        command.args(arguments).stdin(Stdio::null()).output().expect("the program starts");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

#[test]
fn every_step_of_real_time_is_told_and_a_refusal_with_what_would_lift_it() {
    let wish = ["run", "walk", "--quiet", "--realtime", "--set", "duration=0.2", "--rt=10", "--cpu", "999"];
    let (code, words) = told(&wish);
    assert_eq!(code, Some(0), "{words}");
    for role in ["plant", "controller"] {
        let told = |what: &str| words.lines().any(|line| line.starts_with(&format!("{role}: real time: {what}")));
        assert!(told("memory locked: ") && told("SCHED_FIFO at priority 10: "), "{words}");
        assert!(told("processor 999: refused") && words.contains("taskset"), "{words}");
    }
    for line in words.lines().filter(|line| line.contains("refused")) {
        assert!(line.contains("what would grant it: "), "{line}");
    }
}

#[test]
fn real_time_that_is_required_and_refused_ends_with_a_code_of_its_own() {
    let (code, words) = told(&["run", "walk", "--quiet", "--realtime", "--rt=require", "--cpu", "999"]);
    assert_eq!(code, Some(9), "{words}");
    assert!(words.contains("--rt=require: ") && words.contains("refused"), "{words}");
}

#[test]
fn a_loop_that_never_rests_gets_no_real_time_scheduler() {
    let (code, words) = told(&["run", "walk", "--rt"]);
    assert_eq!((code, words.lines().count()), (Some(2), 1), "{words}");
    assert!(words.contains("--rt needs --realtime"), "{words}");
    assert_eq!(told(&["run", "walk", "--realtime", "--rt=100"]).0, Some(2));
}
