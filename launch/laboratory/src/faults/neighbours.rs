//! Disturbances from outside a session: concurrent launchers, foreign files in place of session files, and a controller with much output.

use super::test_session::{FaultTrial, LIMIT, TrialOutcome, is};
use crate::subject::Subject;
use messages::session::Session;
use nix::sys::stat::Mode;
use nix::unistd::mkfifo;
use shared::exit::Exit;
use std::os::unix::fs::symlink;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Concurrent launchers of one session.
const RACERS: usize = 3;
/// Duration of the launchers' walk: it must not end before the last launcher has started [s].
const WALK: &str = "duration=20";

/// Several launchers start the same session at once. One must run to its end, and the others must be refused.
pub fn race() -> FaultTrial {
    let session = Session::unique();
    let start = || Subject::biped(&["run", "walk", "--quiet", "--set", WALK, "--session", session.name()]);
    let racers = (0..RACERS).map(|_| start()).collect::<Result<Vec<_>, _>>()?;
    let ends = racers.into_iter().map(|racer| racer.end(LIMIT * 20)).collect::<Result<Vec<_>, _>>()?;
    let count = |exit| ends.iter().filter(|(status, _)| is(*status, exit)).count();
    let (ran, refused) = (count(Exit::Ok), count(Exit::Incompatible));
    // a launcher that starts after the end of the first one also runs
    if ran == 0 || ran + refused < RACERS {
        return Err(format!("{ran} ran and {refused} were refused: {ends:?}"));
    }
    cleared(&session, TrialOutcome { time: None, remark: "one runs, the others are refused".into() })
}

/// A pipe, a link or a folder in place of a session's member list must be reported. The
/// program must neither wait for the pipe nor follow the link.
pub fn foreign_file(random: &mut fastrand::Rng) -> FaultTrial {
    let session = Session::unique();
    let list = Path::new("/dev/shm").join(session.prefix() + "members");
    let foreign_file = match random.u32(0..3) {
        0 => mkfifo(&list, Mode::S_IRWXU).map_err(Into::into),
        1 => symlink("/dev/zero", &list),
        _ => std::fs::create_dir(&list),
    };
    foreign_file.map_err(|error| error.to_string())?;
    let start = Instant::now();
    let ended = Subject::biped(&["run", "walk", "--quiet", "--session", session.name()])?.end(LIMIT);
    let took = start.elapsed();
    let _ = std::fs::remove_file(&list).or_else(|_| std::fs::remove_dir(&list));
    match ended? {
        (status, output) if is(status, Exit::SharedMemory) && output.contains("is not a regular file") => {
            cleared(&session, took.into())
        }
        (status, output) => Err(format!("{status}: {output}")),
    }
}

/// The standard error of a controller must be read to its end, even if it contains non-text bytes and an endless line.
pub fn much_output(random: &mut fastrand::Rng) -> FaultTrial {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let bytes = random.u32(1 << 20..1 << 24);
    let controller = format!(
        "sh -c \"echo 'error: early' >&2; head -c {bytes} /dev/urandom >&2; exec '{}' controller\"",
        program.display()
    );
    let start = Instant::now();
    let session = Session::unique();
    let walk = ["run", "walk", "--quiet", "--session", session.name(), "--controller", &controller];
    let (status, output) = Subject::biped(&walk)?.end(LIMIT * 20)?;
    match is(status, Exit::Ok) {
        true => cleared(&session, start.elapsed().into()),
        false => Err(format!("{status} after {bytes} bytes: {}", output.lines().last().unwrap_or_default())),
    }
}

/// Checks that no file of the session is left.
fn cleared(session: &Session, outcome: TrialOutcome) -> FaultTrial {
    let start = Instant::now();
    let mut left: Vec<PathBuf> = session.shm_files();
    while !left.is_empty() && start.elapsed() < LIMIT {
        std::thread::sleep(Duration::from_millis(5));
        left = session.shm_files();
    }
    if left.is_empty() { Ok(outcome) } else { Err(format!("files remain: {left:?}")) }
}
