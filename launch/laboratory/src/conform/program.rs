//! The program under test: started as `biped run` starts it, and always ended.

use crate::subject::Subject;
use messages::peer_environment::PeerEnvironment;
use messages::port::{Contract, Pace};
use messages::scene::Scene;
use messages::session::Session;
use nix::sys::signal::Signal;
use sessions::children;
use sessions::process::child_command;
use std::fmt::Arguments;
use std::os::unix::process::ExitStatusExt;
use std::process::ExitStatus;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Time limit for the program to end after the request to end.
pub const END_LIMIT: Duration = Duration::from_secs(3);

/// The tested program and the scene.
pub struct ProgramSetup<'a> {
    pub command: String,
    pub scene: Scene,
    /// Time limit for the start of the program and for its answers.
    pub patience: Duration,
    /// Ctrl-C ends every wait for the program.
    pub stop: &'a AtomicBool,
}

impl<'a> ProgramSetup<'a> {
    /// A unique session with the scene's contract.
    pub fn environment(&self, pace: Pace) -> PeerEnvironment {
        let (scene, session) = (self.scene.clone(), Session::unique());
        PeerEnvironment {
            session,
            contract: Contract::of(&scene, pace),
            patience: self.patience,
            scene,
            takes_over: false,
        }
    }

    /// Starts the program in the session.
    pub fn start(&self, environment: &PeerEnvironment) -> Result<ProgramUnderTest<'a>, String> {
        let variables = children::environment_variables(environment).map_err(|failure| failure.message)?;
        let mut command =
            child_command(&children::become_arguments(&self.command)).map_err(|error| error.to_string())?;
        Ok(ProgramUnderTest { process: Some(Subject::start_group(command.envs(variables))?), stop: self.stop })
    }
}

/// A process of the program, with its child processes.
pub struct ProgramUnderTest<'a> {
    process: Option<Subject>,
    stop: &'a AtomicBool,
}

impl ProgramUnderTest<'_> {
    /// Checks whether a message that has been awaited since `start` may still arrive. `missing` begins the error.
    ///
    /// # Errors
    /// If it has ended, or its patience is over, or Ctrl-C.
    pub fn may_answer(&mut self, missing: Arguments, start: Instant, patience: Duration) -> Result<(), String> {
        if self.stop.load(Relaxed) {
            return Err("interrupted".into());
        }
        if self.has_ended() {
            return Err(format!("{missing}, for it ended: {}", self.end(END_LIMIT)?));
        }
        match start.elapsed() > patience {
            true => Err(format!("{missing} within {} s", patience.as_secs_f64())),
            false => Ok(()),
        }
    }

    /// Whether the process has ended.
    pub fn has_ended(&mut self) -> bool {
        self.process.as_mut().is_none_or(Subject::has_ended)
    }

    /// Sends a signal to the process and its child processes.
    pub fn signal(&mut self, signal: Signal) {
        if let Some(process) = &mut self.process {
            process.signal(signal);
        }
    }

    /// Whether the process or one of its children holds the session's lock.
    pub fn is_member_of(&self, session: &Session) -> bool {
        session.members().iter().any(|member| *member != std::process::id())
    }

    /// Waits for the end of the process. Returns exit status and standard error.
    pub fn end(&mut self, limit: Duration) -> Result<Ended, String> {
        let process = self.process.take().ok_or("it has ended already")?;
        let (status, text) =
            process.end(limit).map_err(|_| format!("it was still there after {} s", limit.as_secs_f64()))?;
        Ok(Ended { status, text })
    }
}

/// The end of a program under test.
pub struct Ended {
    status: ExitStatus,
    text: String,
}

impl Ended {
    /// A regular end: exit code 0, or another one that is allowed here.
    pub fn in_order(&self, others: &[i32]) -> Result<String, String> {
        match self.status.code() {
            Some(code) if code == 0 || others.contains(&code) => Ok(format!("exit code {code}")),
            _ => Err(self.to_string()),
        }
    }

    /// A refusal: an exit code other than 0, and a sentence.
    pub fn by_refusing(&self) -> Result<String, String> {
        if self.text.contains("Traceback ") || self.text.contains("panicked at") {
            return Err(format!("it crashed, {self}"));
        }
        match (self.status.code(), self.sentence()) {
            (Some(1..), Some(_)) => Ok(self.to_string()),
            (Some(1..), None) => Err(format!("it ended with {} and wrote nothing to standard error", self.status)),
            _ => Err(self.to_string()),
        }
    }

    /// The explanation of the program: its error message, or else its last line.
    fn sentence(&self) -> Option<&str> {
        let error = self.text.lines().find_map(|line| line.strip_prefix("error: "));
        error.or_else(|| self.text.lines().rfind(|line| !line.trim().is_empty()))
    }
}

impl std::fmt::Display for Ended {
    fn fmt(&self, f: &mut std::fmt::Formatter) -> std::fmt::Result {
        let how = match (self.status.code(), self.status.signal()) {
            (Some(code), _) => format!("exit code {code}"),
            (None, Some(signal)) => format!("killed by signal {signal}"),
            (None, None) => self.status.to_string(),
        };
        match self.sentence() {
            Some(sentence) => write!(f, "{how}: {sentence}"),
            None => f.write_str(&how),
        }
    }
}
