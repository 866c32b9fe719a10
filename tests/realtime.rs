//! Claims about real-time settings: each is reported, and a refusal names a remedy.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::{Command, Output, Stdio};

/// Exit code and standard error.
fn biped(arguments: &[&str]) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    let Output { status, stderr, .. } =
        command.args(arguments).stdin(Stdio::null()).output().expect("the program starts");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

#[test]
fn every_real_time_setting_is_reported_and_a_refusal_names_a_remedy() {
    let arguments = ["run", "walk", "--quiet", "--realtime", "--set", "duration=0.2", "--rt=10", "--cpu", "999"];
    let (code, words) = biped(&arguments);
    assert_eq!(code, Some(0), "{words}");
    for role in ["plant", "controller"] {
        let reports = |what: &str| words.lines().any(|line| line.starts_with(&format!("{role}: real time: {what}")));
        assert!(reports("memory locked: ") && reports("SCHED_FIFO at priority 10: "), "{words}");
        assert!(reports("processor 999: refused") && words.contains("taskset"), "{words}");
    }
    for line in words.lines().filter(|line| line.contains("refused")) {
        assert!(line.contains("what would grant it: "), "{line}");
    }
}

#[test]
fn required_real_time_that_is_refused_has_its_own_exit_code() {
    let (code, words) = biped(&["run", "walk", "--quiet", "--realtime", "--rt=require", "--cpu", "999"]);
    assert_eq!(code, Some(9), "{words}");
    assert!(words.contains("--rt=require: ") && words.contains("refused"), "{words}");
}

#[test]
fn a_lockstep_run_refuses_the_real_time_scheduler() {
    let (code, words) = biped(&["run", "walk", "--rt"]);
    assert_eq!((code, words.lines().count()), (Some(2), 1), "{words}");
    assert!(words.contains("--rt needs --realtime"), "{words}");
    assert_eq!(biped(&["run", "walk", "--realtime", "--rt=100"]).0, Some(2));
}
