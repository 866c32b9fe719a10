//! Claims about `biped doctor` and `biped clean`: they distinguish running sessions from dead ones. This is one test, because a session that
//! another test starts at the same time would remove the files of the dead one.

#![expect(clippy::expect_used, reason = "a test may panic")]

use messages::port::{Contract, Pace, PlantPort};
use messages::scene::Scene;
use messages::session::Session;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

/// Exit code and standard output.
fn biped(role: &str) -> (Option<i32>, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    let Output { status, stdout, .. } = command.arg(role).stdin(Stdio::null()).output().expect("the program runs");
    (status.code(), String::from_utf8_lossy(&stdout).into_owned())
}

#[test]
fn doctor_lists_and_clean_removes_dead_sessions_and_running_ones_stay() {
    let name = |part| Session::named(&format!("test-{}-{part}", std::process::id())).expect("a good name");
    let (dead, alive) = (name("dead"), name("alive"));
    let open = |session: &Session| PlantPort::open(session, &Contract::of(&Scene::default(), Pace::Lockstep));
    let port = open(&dead).expect("plant");
    let list = dead.shm_files().into_iter().find(|path| path.to_string_lossy().ends_with("members")).expect("a list");
    drop(port);
    let _port = open(&alive).expect("plant");
    let (members, files) = (alive.members(), alive.shm_files());
    assert_eq!(members, [std::process::id()]);
    let segment = PathBuf::from(list.to_string_lossy().replace("members", "abandoned"));
    std::fs::write(&list, dead.name()).expect("a list of nobody");
    std::fs::write(&segment, [0; 5000]).expect("a segment");

    let (code, printed) = biped("doctor");
    assert_eq!(code, Some(4), "{printed}");
    for word in ["wire schema", "memlock", "rtprio", "nofile", "kernel", "clock", "processors", "/dev/shm"] {
        assert!(printed.contains(word), "nothing of {word}: {printed}");
    }
    let line = |printed: &str, name: &str| printed.lines().find(|line| line.contains(name)).unwrap_or("").to_string();
    assert!(line(&printed, alive.name()).starts_with("ok"), "{printed}");
    assert!(line(&printed, alive.name()).ends_with(&members[0].to_string()), "{printed}");
    assert!(line(&printed, dead.name()).starts_with("wrong"), "{printed}");

    let (code, printed) = biped("clean");
    assert_eq!(code, Some(0), "{printed}");
    assert!(printed.contains(dead.name()) && printed.contains(&*segment.to_string_lossy()), "{printed}");
    assert!(!printed.contains(alive.name()), "{printed}");
    assert_eq!((dead.shm_files(), alive.shm_files()), (vec![], files));
    let (_, printed) = biped("doctor");
    assert!(!printed.contains(dead.name()) && printed.contains(alive.name()), "{printed}");
}
