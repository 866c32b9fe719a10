//! Plant and controller as child processes: started, watched, and always ended. Either may be a foreign program.

mod stderr;

use crate::export;
use crate::process::{self, Process, WAIT_POLL, child_command};
use clap::Args;
use indicatif::ProgressBar;
use messages::peer_environment::{PeerEnvironment, SUCCEEDS};
use messages::session::Session;
use nix::sys::prctl;
use nix::sys::signal::Signal;
use nix::unistd::{Pid, getppid};
use shared::exit::{Exit, Failure};
use shared::output::log;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stderr::Origin;
pub use stderr::read_stderr;

/// Time that a process has to exit after SIGTERM before it is killed.
const TERMINATION_TIMEOUT: Duration = Duration::from_secs(2);

/// Plant or controller as a child process.
#[derive(Debug)]
pub struct RoleProcess {
    /// `plant` or `controller`.
    pub name: &'static str,
    process: Process,
    errors: Option<JoinHandle<Vec<String>>>,
}

impl RoleProcess {
    /// Starts `biped NAME ARGUMENTS` with additional environment variables. Its standard error is printed line by line above the progress
    /// bar, except its last error, which [`RoleProcess::outcome`] returns. If its standard input is piped, a plant waits after its
    /// initialization for [`RoleProcess::release`].
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(
        name: &'static str,
        arguments: &[String],
        environment: &[(&'static str, String)],
        input: Stdio,
        bar: &ProgressBar,
    ) -> Result<RoleProcess, Failure> {
        let arguments = [&[name.into()], arguments].concat();
        RoleProcess::spawn(name, &arguments, environment, Origin::Own, input, bar)
    }

    /// Releases a held plant by closing its standard input. The death of this process would close it too.
    pub fn release(&mut self) {
        drop(self.process.stdin());
    }

    /// Starts a foreign program, given as a shell command, with additional environment variables. Its standard error is shown, and it
    /// dies with this process.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_foreign(
        name: &'static str,
        command: &str,
        environment: &[(&'static str, String)],
        bar: &ProgressBar,
    ) -> Result<RoleProcess, Failure> {
        RoleProcess::spawn(name, &become_arguments(command), environment, Origin::Foreign, Stdio::null(), bar)
    }

    fn spawn(
        name: &'static str,
        arguments: &[String],
        environment: &[(&'static str, String)],
        origin: Origin,
        input: Stdio,
        bar: &ProgressBar,
    ) -> Result<RoleProcess, Failure> {
        let failed = |error| Failure::new(Exit::Fault, format!("the {name} process cannot be started: {error}"));
        let mut command = child_command(arguments).map_err(failed)?;
        command
            .env_remove(SUCCEEDS) // unless this child does
            .envs(environment.iter().map(|(key, value)| (key, value)))
            .stdin(input)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut process = match origin {
            Origin::Own => Process::start(&mut command),
            Origin::Foreign => Process::start_group(&mut command),
        }
        .map_err(failed)?;
        let bar = bar.clone();
        let show = move |line: &str| bar.suspend(|| log(format_args!("{name}: {line}")));
        let errors = process.stderr().map(|stderr| stderr::forward(stderr, origin, show)).transpose()?;
        Ok(RoleProcess { name, process, errors })
    }

    /// Process ID.
    pub fn pid(&self) -> u32 {
        self.process.pid()
    }

    /// Checks whether it has exited, and returns its exit status if so.
    pub fn try_wait(&mut self) -> Option<ExitStatus> {
        self.process.try_wait()
    }

    /// The result of the last check for its exit.
    pub fn status(&self) -> Option<ExitStatus> {
        self.process.status()
    }

    /// Checks whether it has crashed: by a signal, or with [`Exit::Fault`]. After any other exit code a restart would end in the same way.
    pub fn crash(&mut self) -> Option<ExitStatus> {
        self.try_wait().filter(|status| Exit::of_child(status.code()) == Exit::Fault)
    }

    /// Sends SIGTERM to the process. A stopped process is continued first, so that it can exit.
    pub fn terminate(&mut self) {
        self.process.signal(Signal::SIGTERM);
        self.process.signal(Signal::SIGCONT);
    }

    /// The outcome at the last check for its exit: success as long as it runs, or if it exited with code 0.
    ///
    /// # Errors
    /// If it failed, with its exit code and its last error.
    pub fn outcome(&mut self) -> Result<(), Failure> {
        let Some(status) = self.process.status() else { return Ok(()) };
        if status.success() {
            return Ok(());
        }
        let words = self.errors.take().and_then(|reader| reader.join().ok()).unwrap_or_default();
        let words = if words.is_empty() { String::new() } else { format!(": {}", words.join("\n")) };
        let (exit, words) = match status.signal() == Some(Signal::SIGBUS as i32) {
            true => (Exit::SharedMemory, format!(": /dev/shm is full{words}")),
            false => (Exit::of_child(status.code()), words),
        };
        Err(Failure::new(exit, format!("the {} failed ({status}){words}", self.name)))
    }
}

/// Terminates all processes and kills those that do not exit in time. `meanwhile` is called while waiting, for example to drain a topic
/// that blocks them.
pub fn terminate_all(roles: &mut [RoleProcess], mut meanwhile: impl FnMut()) {
    roles.iter_mut().for_each(RoleProcess::terminate);
    wait_for_all(roles, TERMINATION_TIMEOUT, &mut meanwhile);
    roles.iter_mut().for_each(|role| role.process.signal(Signal::SIGKILL));
    wait_for_all(roles, TERMINATION_TIMEOUT, &mut meanwhile);
}

/// Waits until all processes have exited by themselves, for a limited time.
pub fn wait_for_all(roles: &mut [RoleProcess], limit: Duration, mut meanwhile: impl FnMut()) {
    let start = Instant::now();
    while roles.iter_mut().any(|role| role.try_wait().is_none()) && start.elapsed() < limit {
        meanwhile();
        sleep_until_exit(roles, WAIT_POLL);
    }
}

/// Sleeps for a time, or until one of the processes exits.
pub fn sleep_until_exit(roles: &[RoleProcess], limit: Duration) {
    process::sleep_until_exit(roles.iter().map(|role| &role.process), limit);
}

/// The environment variables of a foreign program: the session and the scene, the robot as MJCF, and a PATH with `biped`.
///
/// # Errors
/// If the robot of the scene cannot be exported as MJCF.
pub fn environment_variables(environment: &PeerEnvironment) -> Result<Vec<(&'static str, String)>, Failure> {
    let mut variables = environment.variables();
    variables.push(("BIPED_MJCF", export::mjcf(&environment.scene)?));
    variables.push(("PATH", program_path()));
    Ok(variables)
}

/// PATH with the folder of `biped` at its end.
fn program_path() -> String {
    let own_folder = std::env::current_exe().ok().and_then(|program| Some(program.parent()?.display().to_string()));
    std::env::var("PATH").into_iter().chain(own_folder).collect::<Vec<_>>().join(":")
}

/// Checks that the shell finds the program of a command. A command that begins with more than a plain name or path is left to the shell.
///
/// # Errors
/// A sentence with the name of the missing program.
pub fn require_program(command: &str) -> Result<(), String> {
    let program = command.split_whitespace().next().unwrap_or_default();
    let is_plain = program.chars().all(|letter| letter.is_alphanumeric() || "/._-+".contains(letter));
    let mut search = Command::new("sh");
    search.args(["-c", "command -v \"$1\"", "sh", program]).env("PATH", program_path());
    let is_missing = search.output().is_ok_and(|search| !search.status.success());
    match is_plain && is_missing {
        true => Err(format!("there is no program `{program}`: give its path, or the name of a program in PATH")),
        false => Ok(()),
    }
}

/// Removes the files of a session when it is dropped. Drop it after all processes of the session have exited.
pub struct SessionCleanup(pub Session);

impl Drop for SessionCleanup {
    fn drop(&mut self) {
        self.0.remove_files();
    }
}

/// Arguments of this program that make it become a foreign program, given as a shell command.
pub fn become_arguments(command: &str) -> [String; 2] {
    ["become".into(), command.into()]
}

/// Arguments of the hidden command `biped become`, by which this program starts foreign programs.
#[derive(Args)]
pub struct BecomeArgs {
    /// Shell command: program and arguments
    command: String,
    /// ID of the parent process: this process dies with it
    #[arg(long)]
    parent: i32,
}

/// Replaces this process by a foreign program that dies with the parent.
///
/// # Errors
/// If the parent is already dead, or there is no shell.
pub fn exec_foreign(args: &BecomeArgs) -> Result<(), Failure> {
    die_with_parent(args.parent)?;
    // The shell replaces itself by `exec`. Otherwise the shell would die with the parent, and the program would stay.
    let error = Command::new("sh").args(["-c", &format!("exec {}", args.command)]).exec();
    Err(Failure::new(Exit::Fault, format!("there is no shell to start `{}`: {error}", args.command)))
}

/// In a child process: has the system send SIGTERM when the parent dies for any reason.
///
/// # Errors
/// If the parent is already dead.
pub fn die_with_parent(parent: i32) -> Result<(), Failure> {
    let set = prctl::set_pdeathsig(Signal::SIGTERM);
    match set.is_ok() && getppid() == Pid::from_raw(parent) {
        true => Ok(()),
        false => Err(Failure::new(Exit::Interrupted, "the process that started this one has ended")),
    }
}
