//! Mount namespaces with a small or private /dev/shm.

use super::test_session::{FaultTrial, LIMIT, TrialOutcome};
use crate::subject::Subject;
use nix::mount::{MsFlags, mount};
use nix::sched::{CloneFlags, unshare};
use std::process::Command;
use std::time::{Duration, Instant};

/// Runs a short walk with `kilobytes` of shared memory; with `fill`, another process fills it after that time.
pub fn full(kilobytes: u64, fill: Option<Duration>) -> FaultTrial {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let fill = fill.map_or(String::new(), |after| {
        format!("(sleep {}; head -c {}k /dev/zero > /dev/shm/filler) 2>&- &", after.as_secs_f64(), kilobytes)
    });
    // exit code 99 with names: files are left
    let script = format!(
        "mount -t tmpfs -o size={kilobytes}k tmpfs /dev/shm || exit 98; {fill} \
         '{}' run walk --quiet --set duration=20; code=$?; wait; rm -f /dev/shm/filler; \
         if [ -n \"$(ls -A /dev/shm)\" ]; then ls -A /dev/shm >&2; exit 99; fi; exit $code",
        program.display()
    );
    let start = Instant::now();
    let process =
        Subject::start(Command::new("unshare").args(["--user", "--map-root-user", "--mount", "sh", "-c", &script]))?;
    let (status, output) = process.end(LIMIT * 10)?;
    let took = start.elapsed();
    let first = output.lines().find(|line| line.contains("error")).unwrap_or("").trim().to_string();
    match status.code() {
        Some(0) => Ok(TrialOutcome { time: Some(took), remark: String::new() }),
        Some(6) if output.contains("/dev/shm") => Ok(TrialOutcome { time: Some(took), remark: first }),
        Some(4) if output.contains("SIGBUS") => Ok(TrialOutcome { time: Some(took), remark: first }),
        Some(99) => Err(format!("files remain: {output}")),
        _ => Err(format!("{kilobytes} kB: {status}: {output}")),
    }
}

/// Whether the system permits mount namespaces.
pub fn is_permitted() -> bool {
    let mut try_it = Command::new("unshare");
    try_it.args(["--user", "--map-root-user", "--mount", "mount", "-t", "tmpfs", "tmpfs", "/dev/shm"]);
    Subject::start(&mut try_it).and_then(|tried| tried.end(LIMIT)).is_ok_and(|(status, _)| status.success())
}

/// Gives the calling thread and its child processes a private shared memory, so that parallel trials neither see nor remove each other's
/// files.
///
/// # Errors
/// A system that does not permit it: only root may.
pub fn of_ones_own() -> nix::Result<()> {
    const NOTHING: Option<&str> = None;
    unshare(CloneFlags::CLONE_NEWNS)?;
    mount(NOTHING, "/", NOTHING, MsFlags::MS_REC | MsFlags::MS_PRIVATE, NOTHING)?;
    mount(Some("tmpfs"), "/dev/shm", Some("tmpfs"), MsFlags::empty(), NOTHING)
}
