//! The process that started a member: whether it has ended, and whether the system still removes it.

use std::os::unix::process::parent_id;
use std::path::{Path, PathBuf};

/// The process that started this one, as it was when this one joined.
#[derive(Debug)]
pub(super) struct ParentProcess {
    pub number: u32,
    /// Time of its start, by which a later process with the same number is told from it [clock ticks].
    start: Option<String>,
}

impl ParentProcess {
    pub fn of(number: u32) -> ParentProcess {
        ParentProcess { number, start: stat(&process(number), START) }
    }

    /// Whether it or its first thread has ended. The system reports the state of the first thread as that of the process.
    pub fn is_lost(&self) -> bool {
        parent_id() != self.number || has_ended(&process(self.number))
    }

    /// Whether one of its threads has not ended.
    pub fn has_threads(&self) -> bool {
        stat(&process(self.number), START) == self.start && has_threads(self.number)
    }

    /// An earlier process with the same number.
    #[cfg(test)]
    pub fn started_before(self) -> ParentProcess {
        ParentProcess { start: Some("0".into()), ..self }
    }
}

/// Whether a process has a thread that has not ended. A zombie has none.
pub fn has_threads(number: u32) -> bool {
    let threads = std::fs::read_dir(process(number).join("task")).into_iter().flatten().flatten();
    threads.into_iter().any(|thread| !has_ended(&thread.path()))
}

/// Position of state and time of start in /proc/N/stat, counted from the end of the name.
const STATE: usize = 0;
const START: usize = 19;

fn process(number: u32) -> PathBuf {
    format!("/proc/{number}").into()
}

/// One field of the status of the process or thread with this folder in /proc, if it exists.
fn stat(folder: &Path, field: usize) -> Option<String> {
    let text = std::fs::read_to_string(folder.join("stat")).ok()?;
    text.rsplit(')').next()?.split_whitespace().nth(field).map(Into::into)
}

/// Whether the process or thread with this folder in /proc has ended.
fn has_ended(folder: &Path) -> bool {
    stat(folder, STATE).is_none_or(|state| state == "Z" || state == "X")
}
