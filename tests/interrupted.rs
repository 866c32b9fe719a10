//! Claim: Ctrl-C ends every long command with exit code 130 and a sentence that names the results that are kept, and no half-written file
//! is left.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::fresh_path;
use messages::session::Session;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::time::{Duration, Instant};

/// The message of commands that write their results at the end.
const NOTHING: &str = "interrupted: nothing is kept, because the results are written at the end";
/// Longest time that a command may take to begin on a busy machine.
const PATIENCE: Duration = Duration::from_secs(120);

/// The sign that a command has begun.
enum Sign {
    /// A line on standard error, which each command writes after some seconds.
    Line,
    /// A file.
    File(&'static str),
}

/// Commands that take minutes, the sign that they have begun, and their message about the results that are kept.
const LONG: [(&[&str], Sign, &str); 7] = [
    (&["chart", "--out", "out"], Sign::Line, NOTHING),
    (&["study", "margins"], Sign::Line, NOTHING),
    (&["latency", "--out", "out"], Sign::Line, NOTHING),
    (
        &["sweep", "walk", "plant.friction=0.3:0.9:400", "--out", "out"],
        Sign::Line,
        "runs are in out/sweep.csv; run the same command again",
    ),
    (&["robustness", "--out", "out"], Sign::Line, "runs are in out/robustness.csv; run the same command again"),
    (
        &["soak", "--minutes", "10000", "--record", "soak.mcap", "--out", "out"],
        Sign::File("soak.mcap"),
        "interrupted before the first sample",
    ),
    (
        &["run", "walk", "--set", "duration=100000", "--record", "walk.mcap", "--out", "out"],
        Sign::File("walk.mcap"),
        "interrupted",
    ),
];

/// A scene whose first control period takes minutes: a million steps of the slowest method.
const ENDLESS_PERIOD: [&str; 9] = [
    "stand10",
    "--set",
    "plant.method=EventDriven",
    "--set",
    "plant.dt=1e-6",
    "--set",
    "rate=1",
    "--set",
    "duration=10",
];

/// The lines of a child's standard error, as they come.
fn lines(child: &mut Child) -> Receiver<String> {
    let (sender, receiver) = channel();
    let errors = BufReader::new(child.stderr.take().expect("a pipe"));
    std::thread::spawn(move || errors.lines().map_while(Result::ok).try_for_each(|line| sender.send(line)));
    receiver
}

/// Waits for the sign. If it is a line on standard error, returns that line.
fn begun(sign: &Sign, lines: &Receiver<String>, folder: &Path) -> String {
    let start = Instant::now();
    match sign {
        Sign::Line => lines.recv_timeout(PATIENCE).expect("a line"),
        Sign::File(name) => {
            while !folder.join(name).exists() {
                assert!(start.elapsed() < PATIENCE, "no {name} after {PATIENCE:?}");
                std::thread::sleep(Duration::from_millis(10));
            }
            String::new()
        }
    }
}

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
    for (arguments, sign, kept) in LONG {
        let folder = fresh_path("interrupted");
        std::fs::create_dir(&folder).expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments).current_dir(&folder).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut child = command.spawn().expect("the program starts");
        let lines = lines(&mut child);
        let first = begun(&sign, &lines, &folder);
        kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("our own child");
        let status = child.wait().expect("it ends");
        let errors = [first].into_iter().chain(lines).collect::<Vec<_>>().join("\n");
        println!("{arguments:?}: {:?} {errors} {:?}", status.code(), files(&folder));
        assert_eq!(status.code(), Some(130), "{arguments:?}: {errors}");
        assert!(errors.contains(kept) && !errors.contains("panicked"), "{arguments:?}: {errors}");
        let half = |name: &String| name.ends_with(".part") || name.ends_with(".tmp") || name.contains("/.");
        assert_eq!(files(&folder).into_iter().find(half), None, "{arguments:?}");
        std::fs::remove_dir_all(folder).expect("our own folder");
    }
}

/// Waits until a child has computed for a second, so that it is within the first control period.
fn computing(child: &Child) {
    let start = Instant::now();
    let ticks = || {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", child.id())).expect("our own child");
        let fields = stat.rsplit_once(") ").expect("its name").1;
        fields.split(' ').nth(11).and_then(|ticks| ticks.parse::<u64>().ok()).expect("its time in user mode")
    };
    while ticks() < 100 {
        assert!(start.elapsed() < PATIENCE, "it does not compute");
        std::thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn term_ends_a_command_whose_control_period_takes_minutes_and_says_what_is_lost() {
    let name = format!("endless-{}", std::process::id());
    let commands: [(&[&str], &str); 3] = [
        (&["run", "--in-process"], "so the results of its run are lost"),
        (&["run", "--in-process", "--record", "endless.mcap"], "its recording is cut off and has no index"),
        (&["plant", "--session", &name], "`biped clean` has to remove the files of its session"),
    ];
    for (arguments, lost) in commands {
        let folder = fresh_path("endless");
        std::fs::create_dir(&folder).expect("a folder");
        let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
        command.args(arguments).args(ENDLESS_PERIOD).arg("--quiet").current_dir(&folder);
        let mut child = command
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .expect("the program starts");
        computing(&child);
        let lines = lines(&mut child);
        kill(Pid::from_raw(child.id() as i32), Signal::SIGTERM).expect("our own child");
        let (start, status) = (Instant::now(), child.wait().expect("it ends"));
        let errors = lines.into_iter().collect::<Vec<_>>().join("\n");
        println!("{arguments:?}: {:?} after {:?}: {errors}", status.code(), start.elapsed());
        assert_eq!(status.code(), Some(130), "{arguments:?}: {errors}");
        assert!(errors.contains("did not end within") && errors.contains(lost), "{arguments:?}: {errors}");
        std::fs::remove_dir_all(folder).expect("our own folder");
    }
    Session::named(&name).expect("a name").remove_files();
}
