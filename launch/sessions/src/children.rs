//! The two processes: started, watched, and never left behind. Either may be somebody else's program.

mod stderr;

use crate::export;
use crate::process::{self, Process};
use clap::Args;
use indicatif::ProgressBar;
use messages::peer_environment::PeerEnvironment;
use messages::session::Session;
use nix::sys::prctl;
use nix::sys::signal::Signal;
use nix::unistd::{Pid, getppid};
use shared::exit::{Exit, Failure};
use shared::output::tell;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stderr::Author;
pub use stderr::hear;

/// Time that a process gets to end in order before it is killed.
const GRACE: Duration = Duration::from_secs(2);

/// Plant or controller as a child process.
#[derive(Debug)]
pub struct Role {
    /// `plant` or `controller`.
    pub name: &'static str,
    process: Process,
    complaints: Option<JoinHandle<Vec<String>>>,
}

impl Role {
    /// Starts `biped NAME ARGUMENTS`. What it writes is passed on line by line above the progress bar, but its errors
    /// are kept for [`Role::verdict`].
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(name: &'static str, arguments: &[String], bar: &ProgressBar) -> Result<Role, Failure> {
        Role::spawn(name, &[&[name.into()], arguments].concat(), &[], Author::Ours, Stdio::null(), bar)
    }

    /// The same for a plant that gets ready, but says nothing until [`Role::begin`].
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn hold(name: &'static str, arguments: &[String], bar: &ProgressBar) -> Result<Role, Failure> {
        Role::spawn(name, &[&[name.into()], arguments].concat(), &[], Author::Ours, Stdio::piped(), bar)
    }

    /// Lets it go on: the end of its standard input tells it to, as our death would.
    pub fn begin(&mut self) {
        drop(self.process.stdin());
    }

    /// Starts somebody else's program, named as to a shell, with these environment variables. It is treated as our own
    /// are: what it writes to its standard error is shown, and it dies with us.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn foreign(
        name: &'static str,
        command: &str,
        environment: &[(&'static str, String)],
        bar: &ProgressBar,
    ) -> Result<Role, Failure> {
        Role::spawn(name, &["become".into(), command.into()], environment, Author::Foreign, Stdio::null(), bar)
    }

    fn spawn(
        name: &'static str,
        arguments: &[String],
        environment: &[(&'static str, String)],
        author: Author,
        input: Stdio,
        bar: &ProgressBar,
    ) -> Result<Role, Failure> {
        let failed = |error| Failure::new(Exit::Fault, format!("the {name} process cannot be started: {error}"));
        let mut command = Command::new(std::env::current_exe().map_err(failed)?);
        command
            .args(arguments)
            .args(["--parent", &std::process::id().to_string()])
            .envs(environment.iter().map(|(key, value)| (key, value)))
            .stdin(input)
            .stdout(Stdio::null())
            .stderr(Stdio::piped());
        let mut process = match author {
            Author::Ours => Process::start(&mut command),
            Author::Foreign => Process::start_group(&mut command),
        }
        .map_err(failed)?;
        let bar = bar.clone();
        let show = move |line: &str| bar.suspend(|| tell(format_args!("{name}: {line}")));
        let complaints = process.stderr().map(|stderr| stderr::listen(stderr, author, show));
        Ok(Role { name, process, complaints })
    }

    /// The number of the process.
    pub fn number(&self) -> u32 {
        self.process.number()
    }

    /// Its exit status, once it has ended.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        self.process.ended()
    }

    /// The same as of the last look.
    pub fn status(&self) -> Option<ExitStatus> {
        self.process.status()
    }

    /// What killed it, if it died: a signal, or a fault of its own. Whoever ends with any other code has said why, and
    /// would say so again.
    pub fn death(&mut self) -> Option<ExitStatus> {
        self.ended().filter(|status| Exit::of_child(status.code()) == Exit::Fault)
    }

    /// Asks it to end in order, also if it has been stopped.
    pub fn ask_to_end(&mut self) {
        self.process.signal(Signal::SIGTERM);
        self.process.signal(Signal::SIGCONT);
    }

    /// What it had ended with when [`Role::ended`] or [`Role::death`] last looked: nothing if in order, else its exit code and
    /// its last words.
    ///
    /// # Errors
    /// If it failed, with the exit code that says how.
    pub fn verdict(&mut self) -> Result<(), Failure> {
        let Some(status) = self.process.status() else { return Ok(()) };
        if status.success() {
            return Ok(());
        }
        let words = self.complaints.take().and_then(|listener| listener.join().ok()).unwrap_or_default();
        let words = if words.is_empty() { String::new() } else { format!(": {}", words.join("\n")) };
        let (exit, words) = match status.signal() == Some(Signal::SIGBUS as i32) {
            true => (Exit::SharedMemory, format!(": /dev/shm is full{words}")),
            false => (Exit::of_child(status.code()), words),
        };
        Err(Failure::new(exit, format!("the {} failed ({status}){words}", self.name)))
    }
}

/// Asks every process to end, and waits for it, `meanwhile` doing what they may be waiting for; kills what does not.
pub fn end(roles: &mut [Role], mut meanwhile: impl FnMut()) {
    roles.iter_mut().for_each(Role::ask_to_end);
    wait(roles, GRACE, &mut meanwhile);
    roles.iter_mut().for_each(|role| role.process.signal(Signal::SIGKILL));
    wait(roles, GRACE, &mut meanwhile);
}

/// Waits for every process to end by itself, for a limited time.
pub fn wait(roles: &mut [Role], limit: Duration, mut meanwhile: impl FnMut()) {
    let start = Instant::now();
    while roles.iter_mut().any(|role| role.ended().is_none()) && start.elapsed() < limit {
        meanwhile();
        rest(roles, Duration::from_millis(1));
    }
}

/// Sleeps for a time, or until one of the processes ends.
pub fn rest(roles: &[Role], limit: Duration) {
    process::rest(roles.iter().map(|role| &role.process), limit);
}

/// All that somebody else's program must know to take part: the invitation, and the robot. `biped` is among its programs.
///
/// # Errors
/// If the scene has no robot that MJCF can say.
pub fn environment(invitation: &PeerEnvironment) -> Result<Vec<(&'static str, String)>, Failure> {
    let mut environment = invitation.environment();
    environment.push(("BIPED_MJCF", export::mjcf(&invitation.scene)?));
    let ours = std::env::current_exe().ok().and_then(|program| Some(program.parent()?.display().to_string()));
    let path = std::env::var("PATH").into_iter().chain(ours);
    environment.push(("PATH", path.collect::<Vec<_>>().join(":")));
    Ok(environment)
}

/// A session that is cleared away when it is dropped, after every process of it has ended.
pub struct Swept(pub Session);

impl Drop for Swept {
    fn drop(&mut self) {
        self.0.remove_files();
    }
}

/// Arguments of `biped become`, which this program gives to itself.
#[derive(Args)]
pub struct BecomeArgs {
    /// Program and arguments, as to a shell
    command: String,
    /// Process to die with
    #[arg(long)]
    parent: i32,
}

/// Becomes somebody else's program that dies with the parent.
///
/// # Errors
/// If the parent is dead already or there is no shell.
pub fn become_other(args: &BecomeArgs) -> Result<(), Failure> {
    die_with(args.parent)?;
    // the shell steps aside, or it would die with us and leave the program behind
    let error = Command::new("sh").args(["-c", &format!("exec {}", args.command)]).exec();
    Err(Failure::new(Exit::Fault, format!("there is no shell to start `{}`: {error}", args.command)))
}

/// In a child: asks the system for a TERM when the parent dies, however it dies.
///
/// # Errors
/// If it is dead already.
pub fn die_with(parent: i32) -> Result<(), Failure> {
    let asked = prctl::set_pdeathsig(Signal::SIGTERM);
    match asked.is_ok() && getppid() == Pid::from_raw(parent) {
        true => Ok(()),
        false => Err(Failure::new(Exit::Interrupted, "the process that started this one has ended")),
    }
}
