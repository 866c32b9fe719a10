//! Claims about the processes: the results do not depend on how the processes are started, and every kind of end is orderly.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod busy;
mod ends;
mod foreign_programs;
mod hostile;
mod same;

use messages::port::RecorderPort;
use messages::session::Session;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::PathBuf;
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for any condition: far more than a busy machine needs.
const LONG: Duration = Duration::from_secs(60);

fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
    command
}

fn start(arguments: &[&str]) -> Child {
    biped(arguments).spawn().expect("the program starts")
}

/// Waits for the exit of a process. Returns its exit code and standard error.
fn end(child: Child) -> (Option<i32>, String) {
    let Output { status, stderr, .. } = child.wait_with_output().expect("the program ends");
    (status.code(), String::from_utf8_lossy(&stderr).into_owned())
}

fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONG, "{what} did not come true");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn fresh_folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("biped-test-{}-{name}", std::process::id()));
    let _ = std::fs::remove_dir_all(&folder);
    folder
}

/// A session that only this test uses.
fn session(name: &str) -> Session {
    Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name")
}

/// A child of `biped run`.
struct RunningRole {
    name: String,
    pid: i32,
    session: Session,
}

/// The children of a launcher that already run as plant or controller.
fn roles_of(launcher: u32) -> Vec<RunningRole> {
    let list = std::fs::read_to_string(format!("/proc/{launcher}/task/{launcher}/children")).unwrap_or_default();
    let role = |pid: &str| {
        let line = std::fs::read_to_string(format!("/proc/{pid}/cmdline")).ok()?;
        let words: Vec<_> = line.split('\0').collect();
        let session = words.iter().position(|word| *word == "--session")?;
        let session = Session::named(words.get(session + 1)?).ok()?;
        Some(RunningRole { name: words[1].into(), pid: pid.parse().ok()?, session })
    };
    list.split_whitespace().filter_map(role).collect()
}

fn is_running(pid: i32) -> bool {
    // A zombie has exited, even if no process of this container reaps orphans.
    let stat = std::fs::read_to_string(format!("/proc/{pid}/stat")).unwrap_or_default();
    stat.rsplit(')').next().is_some_and(|rest| !rest.trim().is_empty() && !rest.trim().starts_with('Z'))
}

/// A long real-time walk that has started, and its two children.
fn walking() -> (Child, Vec<RunningRole>) {
    let launcher = start(&["run", "walk", "--realtime", "--quiet", "--set", "duration=300"]);
    let mut roles = vec![];
    eventually("two connected processes", || {
        roles = roles_of(launcher.id());
        roles.len() == 2
    });
    let mut observer = None;
    eventually("the first control periods", || {
        if observer.is_none() {
            observer = RecorderPort::attach(&roles[0].session).ok(); // the session may not be open yet
        }
        let truth = observer.as_mut().and_then(|port| port.read().expect("reading").map(|truth| truth.stamp.seq));
        truth.is_some_and(|periods| periods > 100)
    });
    (launcher, roles)
}

/// Asserts that all processes exit and that no session files are left.
fn assert_all_gone(roles: &[RunningRole]) {
    eventually("the end of the processes", || !roles.iter().any(|role| is_running(role.pid)));
    assert_eq!(roles[0].session.shm_files(), Vec::<PathBuf>::new());
}

fn send(pid: i32, signal: Signal) {
    kill(Pid::from_raw(pid), signal).expect("a signal to our own child");
}
