//! Real processes under test: started, found by the name of their session, signalled, and observed until they end.

use crate::subject::{Subject, eventually};
use messages::port::{Action, ask};
use messages::scene::Scene;
use messages::session::{Session, has_threads};
use messages::wire::Truth;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use shared::args::SceneArgs;
use shared::exit::{Exit, Failure};
use std::process::ExitStatus;
use std::time::{Duration, Instant};

/// Time limit for the processes under test.
pub const LIMIT: Duration = Duration::from_secs(3);
/// Time limit for everything else: a busy machine starts processes slowly.
pub const LONG: Duration = Duration::from_secs(60);

/// The result of a trial: a time and a remark, or a sentence about the failure.
pub type FaultTrial = Result<TrialOutcome, String>;

/// The result of a successful trial.
#[derive(Clone, Debug, Default)]
pub struct TrialOutcome {
    /// The measured time, if any.
    pub time: Option<Duration>,
    /// A remark.
    pub remark: String,
}

impl From<Duration> for TrialOutcome {
    fn from(time: Duration) -> TrialOutcome {
        TrialOutcome { time: Some(time), remark: String::new() }
    }
}

/// A process of a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SessionRole {
    /// `biped plant`.
    Plant,
    /// `biped controller`.
    Controller,
    /// `biped run`.
    Launcher,
}

impl SessionRole {
    /// Name on the command line.
    pub fn name(self) -> &'static str {
        match self {
            SessionRole::Plant => "plant",
            SessionRole::Controller => "controller",
            SessionRole::Launcher => "run",
        }
    }

    /// Name in messages.
    pub fn title(self) -> &'static str {
        if self == SessionRole::Launcher { "launcher" } else { self.name() }
    }
}

/// A session under test and its launcher.
pub struct TestSession {
    /// The session's name is an argument of each of its processes.
    pub session: Session,
    launcher: Option<Subject>,
}

impl TestSession {
    /// A session without processes.
    pub fn empty() -> TestSession {
        TestSession { session: Session::unique(), launcher: None }
    }

    /// `biped run walk` with more arguments.
    pub fn run(arguments: &[&str]) -> Result<TestSession, String> {
        let mut test_session = TestSession::empty();
        let name = test_session.session.name().to_string();
        let all = [&["run", "walk", "--quiet", "--session", &name], arguments].concat();
        test_session.launcher = Some(Subject::biped(&all)?);
        Ok(test_session)
    }

    /// Waits until the controller drives the plant.
    pub fn is_set(&mut self) -> Result<(), String> {
        let mut is_over = false;
        eventually("the robot is driven", LONG, || {
            is_over = self.launcher.as_mut().is_none_or(Subject::has_ended);
            is_over || ask(&self.session, Action::Rearm).is_ok_and(|reply| reply.stamp.seq > 1)
        })?;
        match &mut self.launcher {
            Some(launcher) if is_over => {
                Err(format!("the run was over before it was seen to begin: {}", launcher.output()))
            }
            _ => Ok(()),
        }
    }

    /// Process numbers of the running processes in a role.
    pub fn find(&self, role: SessionRole) -> Vec<u32> {
        self.living().into_iter().filter(|(_, found)| found == role.name()).map(|(number, _)| number).collect()
    }

    /// Waits for the process of a role and returns its number.
    pub fn wait_for(&self, role: SessionRole) -> Result<u32, String> {
        let mut found = None;
        eventually("the process begins", LONG, || {
            found = self.find(role).first().copied();
            found.is_some()
        })?;
        found.ok_or_else(|| "nobody was found".into())
    }

    /// Every running process that has the session's name among its arguments, by number and role.
    fn living(&self) -> Vec<(u32, String)> {
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_string_lossy().parse().ok());
        let of_it = |number: u32| {
            let line = std::fs::read_to_string(format!("/proc/{number}/cmdline")).ok()?;
            let arguments: Vec<&str> = line.split('\0').collect();
            let is_of_it = arguments.contains(&self.session.name()) && has_threads(number);
            is_of_it.then(|| (number, arguments[1].to_string()))
        };
        numbers.filter_map(of_it).collect()
    }

    /// Checks that the launcher and its child processes end within the limit and leave no files. Returns the time since `start` and the
    /// standard error.
    pub fn must_end(self, start: Instant) -> Result<(Duration, ExitStatus, String), String> {
        let (took, status, output) = self.must_end_some_time(start)?;
        match took > LIMIT {
            true => Err(format!("it took {:.1} s to end: {output}", took.as_secs_f64())),
            false => Ok((took, status, output)),
        }
    }

    /// The same without a limit.
    pub fn must_end_some_time(mut self, start: Instant) -> Result<(Duration, ExitStatus, String), String> {
        let launcher = self.launcher.take().ok_or("there is no launcher")?;
        let (status, output) = launcher.end(LONG)?;
        eventually("every process ends", LONG, || self.living().is_empty())?;
        let took = start.elapsed();
        let left = self.session.shm_files();
        match left.first() {
            Some(file) => Err(format!("{} files are left, such as {}", left.len(), file.display())),
            None => Ok((took, status, output)),
        }
    }
}

impl Drop for TestSession {
    /// Removes the remains of a failed trial.
    fn drop(&mut self) {
        self.launcher = None;
        self.living().iter().for_each(|(number, _)| _ = send(*number, Signal::SIGKILL));
        let _ = eventually("the end", LIMIT, || self.living().is_empty());
        self.session.remove_files();
    }
}

/// Sends a signal to a process of a test session.
pub fn send(number: u32, signal: Signal) -> Result<(), String> {
    let number = i32::try_from(number).map_err(|error| error.to_string())?;
    kill(Pid::from_raw(number), signal).map_err(|error| format!("{signal} cannot be sent: {error}"))
}

/// The scene of `biped plant walk` with these settings.
pub fn walk(settings: &[&str]) -> Result<(SceneArgs, Scene), String> {
    let settings = settings.iter().map(ToString::to_string).collect();
    let args = SceneArgs { scene: "walk".into(), robot: None, settings };
    let scene = args.load().map_err(|failure: Failure| failure.message)?;
    Ok((args, scene))
}

/// Checks that the robot's state is finite.
pub fn is_finite(truth: &Truth) -> Result<(), String> {
    let parts: [&[f64]; 7] = [
        &truth.base_position,
        &truth.base_orientation,
        &truth.base_velocity,
        &truth.base_spin,
        &truth.angle,
        &truth.rate,
        &truth.torque,
    ];
    match parts.iter().all(|part| part.iter().all(|number| number.is_finite())) {
        true => Ok(()),
        false => Err(format!("the robot's state is not finite at period {}", truth.stamp.seq)),
    }
}

/// Whether a process ended with this exit code.
pub fn is(status: ExitStatus, exit: Exit) -> bool {
    status.code() == Some(exit as i32)
}
