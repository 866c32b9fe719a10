//! Disks and file size limits that are too small for a recording. The robot must keep walking, and the recorded part must be readable.

use super::test_session::{FaultTrial, LIMIT, TrialOutcome, is};
use crate::subject::Subject;
use shared::exit::Exit;
use shared::output::temporary_folder;
use std::process::Command;
use std::time::{Duration, Instant};

/// Records on a disk of some megabytes; with `fill`, another process fills the rest of the disk after that time.
pub fn small(megabytes: u64, fill: Option<Duration>) -> FaultTrial {
    let fill = fill.map_or(String::new(), |after| {
        let after = after.as_secs_f64();
        format!("(sleep {after}; head -c {megabytes}M /dev/zero > disk/filler) 2>&- &")
    });
    let mount = format!("mount -t tmpfs -o size={megabytes}M tmpfs disk || exit 98; {fill}");
    // a filled disk has no room for a report
    let (seconds, out) = if fill.is_empty() { (40, "disk/out") } else { (80, "out") };
    trial(&["--user", "--map-root-user", "--mount"], &mount, seconds, out)
}

/// Records under a file size limit of some megabytes.
pub fn limited(megabytes: u64) -> FaultTrial {
    trial(&[], &format!("ulimit -f {}", megabytes * 2048), 80, "out")
}

/// Runs commands and then a recorded walk in a new folder, and in new namespaces if any are named. A second of a walk takes a megabyte.
fn trial(namespaces: &[&str], before: &str, seconds: u32, out: &str) -> FaultTrial {
    let program = std::env::current_exe().map_err(|error| error.to_string())?;
    let folder = temporary_folder("disk").map_err(|error| error.message)?;
    std::fs::create_dir_all(folder.join("disk")).map_err(|error| error.to_string())?;
    let script = format!(
        "biped='{}'; cd '{}' && mkdir out; {before}\n \"$biped\" run walk --quiet --set duration={seconds} --record disk/run.mcap --out {out}; code=$?; wait; rm -f disk/filler; \
         grep -q '\"recording_ended_by\": \"' {out}/summary.json || exit 97; \
         \"$biped\" replay disk/run.mcap > /dev/null || exit 96; exit $code",
        program.display(),
        folder.display()
    );
    let ended = walk(namespaces, &script);
    let _ = std::fs::remove_dir_all(&folder);
    ended
}

fn walk(namespaces: &[&str], script: &str) -> FaultTrial {
    let start = Instant::now();
    let mut command = Command::new(if namespaces.is_empty() { "sh" } else { "unshare" });
    let process = Subject::start(match namespaces {
        [] => command.args(["-c", script]),
        some => command.args(some).args(["sh", "-c", script]),
    })?;
    let (status, output) = process.end(LIMIT * 20)?;
    let sentence = output.lines().find(|line| line.starts_with("the recording")).unwrap_or("").to_string();
    let is_reported = sentence.contains("ends at") && sentence.contains("the run continues");
    match is(status, Exit::Unrecorded) && is_reported {
        true => Ok(TrialOutcome { time: Some(start.elapsed()), remark: sentence }),
        false => Err(format!("{status}: {output}")),
    }
}
