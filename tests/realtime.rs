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
    let (code, printed) = biped(&arguments);
    assert_eq!(code, Some(0), "{printed}");
    for role in ["plant", "controller"] {
        let reports = |what: &str| printed.lines().any(|line| line.starts_with(&format!("{role}: real time: {what}")));
        assert!(reports("memory locked: ") && reports("SCHED_FIFO at priority 10: "), "{printed}");
        assert!(reports("processor 999: refused") && printed.contains("--cpu with one of the processors"), "{printed}");
    }
    for line in printed.lines().filter(|line| line.contains("refused")) {
        assert!(line.contains("what would grant it: "), "{line}");
    }
}

#[test]
fn required_real_time_that_is_refused_has_its_own_exit_code() {
    let (code, printed) = biped(&["run", "walk", "--quiet", "--realtime", "--rt=require", "--cpu", "999"]);
    assert_eq!(code, Some(9), "{printed}");
    assert!(printed.contains("--rt=require: ") && printed.contains("refused"), "{printed}");
}

#[test]
fn a_lockstep_run_refuses_the_real_time_scheduler() {
    let (code, printed) = biped(&["run", "walk", "--rt"]);
    assert_eq!((code, printed.lines().count()), (Some(2), 1), "{printed}");
    assert!(printed.contains("--rt needs --realtime"), "{printed}");
    assert_eq!(biped(&["run", "walk", "--realtime", "--rt=100"]).0, Some(2));
}
