//! The program under test: started as `biped run` starts it, and ended whatever it does.

use crate::subject::Subject;
use messages::invitation::Invitation;
use messages::port::{Contract, Pace};
use messages::scene::Scene;
use messages::session::Session;
use nix::sys::signal::Signal;
use sessions::children;
use std::os::unix::process::ExitStatusExt;
use std::process::{Command, ExitStatus};
use std::time::Duration;

/// Within this time it must have ended, once it knows that it should.
pub const GOODBYE: Duration = Duration::from_secs(3);

/// What is tested, in which scene.
pub struct Host {
    pub command: String,
    pub scene: Scene,
    /// How long it may take to start or to answer.
    pub patience: Duration,
}

impl Host {
    /// A session that nobody else has, with the scene's contract.
    pub fn invitation(&self, pace: Pace) -> Invitation {
        let (scene, session) = (self.scene.clone(), Session::unique());
        Invitation { session, contract: Contract::of(&scene, pace), patience: self.patience, scene, succeeds: false }
    }

    /// Starts it there.
    pub fn invite(&self, invitation: &Invitation) -> Result<Guest, String> {
        let environment = children::environment_variables(invitation).map_err(|failure| failure.message)?;
        let program = std::env::current_exe().map_err(|error| error.to_string())?;
        let mut command = Command::new(program);
        command.args(["become", &self.command, "--parent", &std::process::id().to_string()]);
        Ok(Guest { process: Some(Subject::start_group(command.envs(environment))?) })
    }
}

/// One process of it, with whatever it starts.
pub struct Guest {
    process: Option<Subject>,
}

impl Guest {
    /// Whether it has ended.
    pub fn has_ended(&mut self) -> bool {
        self.process.as_mut().is_none_or(Subject::has_ended)
    }

    /// Signals the process and all it has started.
    pub fn signal(&mut self, signal: Signal) {
        if let Some(process) = &mut self.process {
            process.signal(signal);
        }
    }

    /// Whether it, or what it has started, holds the session's lock.
    pub fn is_member_of(&self, session: &Session) -> bool {
        session.members().iter().any(|member| *member != std::process::id())
    }

    /// Waits for its end: how it ended, and what it said.
    pub fn end(&mut self, limit: Duration) -> Result<Ended, String> {
        let process = self.process.take().ok_or("it has ended already")?;
        let (status, words) =
            process.end(limit).map_err(|_| format!("it was still there after {} s", limit.as_secs_f64()))?;
        Ok(Ended { status, words })
    }
}

/// How a guest ended.
pub struct Ended {
    status: ExitStatus,
    words: String,
}

impl Ended {
    /// In order: exit code 0, or one of the others that are allowed here.
    pub fn in_order(&self, others: &[i32]) -> Result<String, String> {
        match self.status.code() {
            Some(code) if code == 0 || others.contains(&code) => Ok(format!("exit code {code}")),
            _ => Err(self.to_string()),
        }
    }

    /// By refusing: an exit code that is not 0, and a sentence.
    pub fn by_refusing(&self) -> Result<String, String> {
        if self.words.contains("Traceback ") || self.words.contains("panicked at") {
            return Err(format!("it crashed, {self}"));
        }
        match (self.status.code(), self.sentence()) {
            (Some(1..), Some(_)) => Ok(self.to_string()),
            (Some(1..), None) => Err(format!("it ended with {} and said nothing on standard error", self.status)),
            _ => Err(self.to_string()),
        }
    }

    /// What it said of its end: its error if it told one, else its last line.
    fn sentence(&self) -> Option<&str> {
        let error = self.words.lines().find_map(|line| line.strip_prefix("error: "));
        error.or_else(|| self.words.lines().rfind(|line| !line.trim().is_empty()))
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
