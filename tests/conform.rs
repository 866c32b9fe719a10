//! Claims about `biped conform`: the built-in controller and plant pass, and a broken rule of another program is named.

#![expect(clippy::expect_used, reason = "a test may panic")]

use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

const BIPED: &str = env!("CARGO_BIN_EXE_biped");

/// Exit code, the lines of the broken rules, and the whole output.
fn conform(arguments: &[&str]) -> (Option<i32>, Vec<String>, String) {
    let output = Command::new(BIPED).arg("conform").args(arguments).output().expect("the program starts");
    let Output { status, stdout, stderr } = output;
    let printed = String::from_utf8_lossy(&stdout).into_owned() + &String::from_utf8_lossy(&stderr);
    let broken = printed.lines().filter(|line| line.starts_with("FAILED")).map(String::from).collect();
    (status.code(), broken, printed)
}

#[test]
fn the_built_in_controller_and_plant_obey_every_rule() {
    for (role, rules) in [("controller", "32 rules kept, 0 broken"), ("plant", "40 rules kept, 0 broken")] {
        let (code, _, printed) = conform(&[&format!("--{role}"), &format!("{BIPED} {role}")]);
        assert!(code == Some(0) && printed.contains(rules), "{printed}");
    }
}

/// Programs that do not use the wire format at all.
#[test]
fn a_program_that_does_nothing_breaks_the_first_rule() {
    let (code, broken, printed) = conform(&["--controller", "sleep 60", "--patience", "0.5"]);
    assert_eq!(code, Some(10), "{printed}");
    assert!(broken[0].contains("answers within its patience: no answer to sensors 1 within 0.5 s"), "{printed}");
    assert!(
        broken.iter().any(|line| line.contains("gives up without a plant") && line.contains("still there")),
        "{printed}"
    );

    let (code, broken, printed) = conform(&["--plant", "sh -c 'echo error: no legs >&2; exit 7'", "--patience", "5"]);
    assert_eq!(code, Some(10), "{printed}");
    assert!(broken[0].contains("sends sensors number 1") && broken[0].contains("exit code 7: no legs"), "{printed}");
    assert!(printed.contains("says little"), "{printed}");
}

#[test]
fn a_background_process_of_the_program_does_not_delay_the_check() {
    let (code, broken, printed) = conform(&["--plant", "sh -c 'sleep 3600 & exit 7'", "--patience", "1"]);
    assert!(code == Some(10) && broken[0].contains("exit code 7"), "{printed}");
}

#[test]
fn an_interrupt_ends_the_wait_for_a_program_that_never_answers() {
    for role in ["--controller", "--plant"] {
        let mut check = Command::new(BIPED);
        check.args(["conform", role, "sleep 60", "--patience", "50"]);
        let child = check.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program starts");
        std::thread::sleep(Duration::from_secs(1)); // until it waits
        let start = Instant::now();
        kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("our own child");
        let Output { status, stderr, .. } = child.wait_with_output().expect("it ends");
        let errors = String::from_utf8_lossy(&stderr);
        assert!(status.code() == Some(130) && errors.starts_with("error: interrupted"), "{role}: {errors}");
        assert!(start.elapsed() < Duration::from_secs(40), "before its patience is over");
    }
}

#[test]
fn controller_or_plant_is_required() {
    let (code, _, printed) = conform(&[]);
    assert!(code == Some(2) && printed.contains("--controller <COMMAND>"), "{printed}");
}
