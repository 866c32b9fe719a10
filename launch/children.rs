//! The two processes: started, watched, and never left behind. Either may be somebody else's program.

mod stderr;

use crate::exit::{Exit, Failure};
use crate::export;
use crate::output::tell;
use clap::Args;
use indicatif::ProgressBar;
use messages::peer_environment::PeerEnvironment;
use messages::session::Session;
use nix::sys::prctl;
use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{Id, WaitPidFlag, WaitStatus, waitid};
use nix::unistd::{Pid, getppid};
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::PidfdFlags;
use std::os::fd::OwnedFd;
use std::os::unix::process::{CommandExt, ExitStatusExt};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use stderr::Author;
pub use stderr::hear;

/// Time that a process gets to end in order before it is killed.
const GRACE: Duration = Duration::from_secs(2);

/// A process of ours: plant or controller.
#[derive(Debug)]
pub struct Role {
    /// `plant` or `controller`.
    pub name: &'static str,
    process: Child,
    /// Whether it is the head of a process group of its own, which is signalled as a whole.
    grouped: bool,
    /// Can be read once it has ended.
    end: Option<OwnedFd>,
    status: Option<ExitStatus>,
    complaints: Option<JoinHandle<Vec<String>>>,
}

impl Role {
    /// Starts `biped NAME ARGUMENTS`. What it writes is passed on line by line above the progress bar, but its errors
    /// are kept for [`Role::verdict`].
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(name: &'static str, arguments: &[String], bar: &ProgressBar) -> Result<Role, Failure> {
        Role::spawn(name, &[&[name.into()], arguments].concat(), &[], false, Stdio::null(), bar)
    }

    /// The same for a plant that gets ready, but says nothing until [`Role::begin`].
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn hold(name: &'static str, arguments: &[String], bar: &ProgressBar) -> Result<Role, Failure> {
        Role::spawn(name, &[&[name.into()], arguments].concat(), &[], false, Stdio::piped(), bar)
    }

    /// Lets it go on: the end of its standard input tells it to, as our death would.
    pub fn begin(&mut self) {
        self.process.stdin = None;
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
        Role::spawn(name, &["become".into(), command.into()], environment, true, Stdio::null(), bar)
    }

    fn spawn(
        name: &'static str,
        arguments: &[String],
        environment: &[(&'static str, String)],
        grouped: bool,
        input: Stdio,
        bar: &ProgressBar,
    ) -> Result<Role, Failure> {
        let failed = |error| Failure::new(Exit::Fault, format!("the {name} process cannot be started: {error}"));
        let mut command = Command::new(std::env::current_exe().map_err(failed)?);
        if grouped {
            command.process_group(0);
        }
        let mut process = command
            .args(arguments)
            .args(["--parent", &std::process::id().to_string()])
            .envs(environment.iter().map(|(key, value)| (key, value)))
            .stdin(input)
            .stdout(Stdio::null())
            .stderr(Stdio::piped())
            .spawn()
            .map_err(failed)?;
        let bar = bar.clone();
        let author = if grouped { Author::Foreign } else { Author::Ours };
        let show = move |line: &str| bar.suspend(|| tell(format_args!("{name}: {line}")));
        let complaints = process.stderr.take().map(|stderr| stderr::listen(stderr, author, show));
        let number = rustix::process::Pid::from_child(&process);
        let end = rustix::process::pidfd_open(number, PidfdFlags::empty()).ok();
        Ok(Role { name, process, grouped, end, status: None, complaints })
    }

    /// The number of the process.
    pub fn number(&self) -> u32 {
        self.process.id()
    }

    /// Its exit status, once it has ended.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            if self.grouped {
                end_rest(&self.process);
            }
            self.status = self.process.try_wait().ok().flatten();
        }
        self.status
    }

    /// The same as of the last look.
    pub fn status(&self) -> Option<ExitStatus> {
        self.status
    }

    /// What killed it, if it died: a signal, or a fault of its own. Whoever ends with any other code has said why, and
    /// would say so again.
    pub fn death(&mut self) -> Option<ExitStatus> {
        self.ended().filter(|status| Exit::of_child(status.code()) == Exit::Fault)
    }

    /// Asks it to end in order, also if it has been stopped.
    pub fn ask_to_end(&mut self) {
        self.signal(Signal::SIGTERM);
        self.signal(Signal::SIGCONT);
    }

    fn signal(&mut self, signal: Signal) {
        // Only while it is not reaped: its number belongs to it.
        if let (None, Ok(pid)) = (self.ended(), i32::try_from(self.process.id())) {
            let _ = kill(Pid::from_raw(if self.grouped { -pid } else { pid }), signal);
        }
    }

    /// What it had ended with when [`Role::ended`] or [`Role::death`] last looked: nothing if in order, else its exit code and
    /// its last words.
    ///
    /// # Errors
    /// If it failed, with the exit code that says how.
    pub fn verdict(&mut self) -> Result<(), Failure> {
        let Some(status) = self.status else { return Ok(()) };
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

impl Drop for Role {
    /// Never leaves a process behind, whatever happened.
    fn drop(&mut self) {
        if self.ended().is_none() {
            self.signal(Signal::SIGKILL);
            let _ = self.process.wait();
        }
    }
}

/// Asks every process to end, and waits for it, `meanwhile` doing what they may be waiting for; kills what does not.
pub fn end(roles: &mut [Role], mut meanwhile: impl FnMut()) {
    roles.iter_mut().for_each(Role::ask_to_end);
    wait(roles, GRACE, &mut meanwhile);
    roles.iter_mut().for_each(|role| role.signal(Signal::SIGKILL));
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

/// Sleeps for so long, or until one of the processes ends.
pub fn rest(roles: &[Role], limit: Duration) {
    let running = roles.iter().filter(|role| role.status.is_none());
    let mut ends: Vec<PollFd> =
        running.filter_map(|role| Some(PollFd::new(role.end.as_ref()?, PollFlags::IN))).collect();
    match Timespec::try_from(limit) {
        Ok(limit) if !ends.is_empty() => _ = poll(&mut ends, Some(&limit)),
        _ => std::thread::sleep(limit),
    }
}

/// Kills what somebody else's program, the first of a group, has started and left behind, once it has ended. Before it is reaped:
/// until then the group's number belongs to it.
pub fn end_rest(process: &Child) {
    let Ok(pid) = i32::try_from(process.id()) else { return };
    let status =
        waitid(Id::Pid(Pid::from_raw(pid)), WaitPidFlag::WEXITED | WaitPidFlag::WNOHANG | WaitPidFlag::WNOWAIT);
    if status.is_ok_and(|status| status != WaitStatus::StillAlive) {
        let _ = kill(Pid::from_raw(-pid), Signal::SIGKILL);
    }
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
