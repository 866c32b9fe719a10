//! A process under test, and its output on standard error.

use nix::sys::signal::Signal;
use sessions::children::read_stderr;
use sessions::process::Process;
use shared::thread;
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

/// A process under test. It is killed when this is dropped.
#[derive(Debug)]
pub struct Subject {
    process: Process,
    output: Option<JoinHandle<String>>,
}

impl Subject {
    /// Starts `biped ARGUMENTS`.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn biped(arguments: &[&str]) -> Result<Subject, String> {
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        Subject::start(Command::new(program).args(arguments))
    }

    /// Starts a command.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(command: &mut Command) -> Result<Subject, String> {
        Subject::started_by(Process::start, command)
    }

    /// Starts a command as the leader of a process group, which is signalled and ended as a whole.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_group(command: &mut Command) -> Result<Subject, String> {
        Subject::started_by(Process::start_group, command)
    }

    fn started_by(
        start: impl FnOnce(&mut Command) -> std::io::Result<Process>,
        command: &mut Command,
    ) -> Result<Subject, String> {
        let silent = command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::piped());
        let mut process = start(silent).map_err(|error| format!("{command:?} cannot be started: {error}"))?;
        let output = process.stderr().map(|pipe| thread::start(move || read_stderr(pipe))).transpose();
        Ok(Subject { process, output: output.map_err(|failure| failure.message)? })
    }

    /// Identifier of the process.
    pub fn number(&self) -> u32 {
        self.process.pid()
    }

    /// Whether the process has ended.
    pub fn has_ended(&mut self) -> bool {
        self.process.try_wait().is_some()
    }

    /// Sends a signal to the process, or to its group.
    pub fn signal(&mut self, signal: Signal) {
        self.process.signal(signal);
    }

    /// The output of the process, after its end.
    pub fn output(&mut self) -> String {
        self.output.take().and_then(|listener| listener.join().ok()).unwrap_or_default()
    }

    /// Waits for the end of the process. Returns its exit status and its output.
    ///
    /// # Errors
    /// If the process has not ended within `limit`.
    pub fn end(mut self, limit: Duration) -> Result<(ExitStatus, String), String> {
        let late = || format!("not within {} s: the process ends", limit.as_secs_f64());
        let status = self.process.wait(limit).ok_or_else(late)?;
        Ok((status, self.output()))
    }
}

/// Waits until a condition holds.
///
/// # Errors
/// If the condition does not hold within the limit.
pub fn eventually(what: &str, limit: Duration, mut holds: impl FnMut() -> bool) -> Result<(), String> {
    let start = Instant::now();
    while !holds() {
        if start.elapsed() > limit {
            return Err(format!("not within {} s: {what}", limit.as_secs_f64()));
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    Ok(())
}
