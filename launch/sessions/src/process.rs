//! A child process. Its exit is noticed at once, signals reach its descendants too, and it never outlives its owner.

use nix::sys::signal::{Signal, kill};
use nix::sys::wait::{Id, WaitPidFlag, WaitStatus, waitid};
use nix::unistd::Pid;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::process::PidfdFlags;
use std::io;
use std::os::fd::OwnedFd;
use std::os::unix::process::CommandExt;
use std::process::{Child, ChildStderr, ChildStdin, ChildStdout, Command, ExitStatus};
use std::time::{Duration, Instant};

/// Interval between two checks while waiting, for systems where an exit cannot be polled.
pub(crate) const WAIT_POLL: Duration = Duration::from_millis(1);

/// A child process. Dropping it kills and reaps it.
#[derive(Debug)]
pub struct Process {
    child: Child,
    /// Whether it leads a process group, which is signalled and killed as a whole.
    is_group: bool,
    /// Becomes readable when the process exits.
    pidfd: Option<OwnedFd>,
    status: Option<ExitStatus>,
}

/// The command `biped ARGUMENTS --parent PID`: this program in a role that dies with this process.
///
/// # Errors
/// If the system does not name this program.
pub fn child_command(arguments: &[String]) -> io::Result<Command> {
    let mut command = Command::new(std::env::current_exe()?);
    command.args(arguments).args(["--parent", &std::process::id().to_string()]);
    Ok(command)
}

impl Process {
    /// Starts a command.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(command: &mut Command) -> io::Result<Process> {
        let child = command.spawn()?;
        let pid = rustix::process::Pid::from_child(&child);
        let pidfd = rustix::process::pidfd_open(pid, PidfdFlags::empty()).ok();
        Ok(Process { child, is_group: false, pidfd, status: None })
    }

    /// Starts a command as the leader of a process group. Its descendants are signalled with it, and killed when it exits.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_group(command: &mut Command) -> io::Result<Process> {
        let mut process = Process::start(command.process_group(0))?;
        process.is_group = true;
        Ok(process)
    }

    /// Process ID.
    pub fn pid(&self) -> u32 {
        self.child.id()
    }

    /// The writing end of its standard input, if that is a pipe. The first call takes it.
    pub fn stdin(&mut self) -> Option<ChildStdin> {
        self.child.stdin.take()
    }

    /// The reading end of its standard output, if that is a pipe. The first call takes it.
    pub fn stdout(&mut self) -> Option<ChildStdout> {
        self.child.stdout.take()
    }

    /// The reading end of its standard error, if that is a pipe. The first call takes it.
    pub fn stderr(&mut self) -> Option<ChildStderr> {
        self.child.stderr.take()
    }

    /// Checks whether it has exited, and returns its exit status if so.
    pub fn try_wait(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            if self.is_group {
                self.kill_orphans();
            }
            self.status = self.child.try_wait().ok().flatten();
        }
        self.status
    }

    /// The result of the last call of [`Process::try_wait`].
    pub fn status(&self) -> Option<ExitStatus> {
        self.status
    }

    /// Sends a signal to it, or to its group. Does nothing once it has exited.
    pub fn signal(&mut self, signal: Signal) {
        // After the process is reaped, the system may give its ID to another one.
        if let (None, Ok(pid)) = (self.try_wait(), i32::try_from(self.child.id())) {
            let _ = kill(Pid::from_raw(if self.is_group { -pid } else { pid }), signal);
        }
    }

    /// Waits until it exits, for a limited time.
    pub fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let start = Instant::now();
        while self.try_wait().is_none() && start.elapsed() < limit {
            sleep_until_exit([&*self], WAIT_POLL);
        }
        self.status
    }

    /// Kills the descendants that an exited leader of a group has left running. This has to happen before the leader is reaped, because
    /// the ID of the group stays reserved only until then.
    fn kill_orphans(&self) {
        let Ok(pid) = i32::try_from(self.child.id()) else { return };
        let flags = WaitPidFlag::WEXITED | WaitPidFlag::WNOHANG | WaitPidFlag::WNOWAIT;
        let status = waitid(Id::Pid(Pid::from_raw(pid)), flags);
        if status.is_ok_and(|status| status != WaitStatus::StillAlive) {
            let _ = kill(Pid::from_raw(-pid), Signal::SIGKILL);
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if self.try_wait().is_none() {
            self.signal(Signal::SIGKILL);
            let _ = self.child.wait();
        }
    }
}

/// Sleeps for a time, or until one of the processes exits.
pub fn sleep_until_exit<'a>(processes: impl IntoIterator<Item = &'a Process>, limit: Duration) {
    let running = processes.into_iter().filter(|process| process.status.is_none());
    let mut exits: Vec<PollFd> =
        running.filter_map(|process| Some(PollFd::new(process.pidfd.as_ref()?, PollFlags::IN))).collect();
    match Timespec::try_from(limit) {
        Ok(limit) if !exits.is_empty() => _ = poll(&mut exits, Some(&limit)),
        _ => std::thread::sleep(limit),
    }
}
