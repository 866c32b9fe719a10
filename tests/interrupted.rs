//! Claim: Ctrl-C ends every long command with a sentence and exit code 130, and no half-written file is left.

mod common;

use common::fresh_path;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// Time for which a command works before the signal, longer than any of them takes to begin on an idle machine.
const WORK: Duration = Duration::from_secs(3);
/// Commands that take minutes.
const LONG: [&[&str]; 7] = [
    &["chart", "--out", "out"],
    &["sweep", "walk", "plant.friction=0.3:0.9:400", "--out", "out"],
    &["study", "margins"],
    &["latency", "--out", "out"],
    &["soak", "--out", "out"],
    &["robustness", "--out", "out"],
    &["run", "walk", "--set", "duration=100000", "--record", "walk.mcap", "--out", "out"],
];

/// Names of all files below a folder.
fn files(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path());
    let names = |path: std::path::PathBuf| match path.is_dir() {
        true => files(&path),
        false => vec![path.display().to_string()],
    };
    entries.flat_map(names).collect()
}

#[test]
fn ctrl_c_ends_every_long_command_in_a_sentence_and_leaves_nothing_half_written() {
    for arguments in LONG {
        let folder = fresh_path("interrupted");
        std::fs::create_dir(&folder).expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments).current_dir(&folder).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
        let child = command.spawn().expect("the program starts");
        std::thread::sleep(WORK);
        kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("our own child");
        let Output { status, stderr, .. } = child.wait_with_output().expect("it ends");
        let errors = String::from_utf8_lossy(&stderr);
        println!("{arguments:?}: {:?} {errors} {:?}", status.code(), files(&folder));
        assert_eq!(status.code(), Some(130), "{arguments:?}: {errors}");
        assert!(errors.contains("interrupted") && !errors.contains("panicked"), "{arguments:?}: {errors}");
        let half = |name: &String| name.ends_with(".part") || name.ends_with(".tmp") || name.contains("/.");
        assert_eq!(files(&folder).into_iter().find(half), None, "{arguments:?}");
        std::fs::remove_dir_all(folder).expect("our own folder");
    }
}
