//! A child process: its end is noticed at once, signals reach whatever it has started, and it never outlives its owner.

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

/// A process that was started here. Dropping it kills and reaps it.
#[derive(Debug)]
pub struct Process {
    child: Child,
    /// Whether it leads a process group, which is signalled and ended as a whole.
    is_group: bool,
    /// Becomes readable when the process ends.
    end: Option<OwnedFd>,
    status: Option<ExitStatus>,
}

impl Process {
    /// Starts a command.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(command: &mut Command) -> io::Result<Process> {
        let child = command.spawn()?;
        let number = rustix::process::Pid::from_child(&child);
        let end = rustix::process::pidfd_open(number, PidfdFlags::empty()).ok();
        Ok(Process { child, is_group: false, end, status: None })
    }

    /// Starts a command as the leader of a process group: the processes that it starts are signalled with it, and killed when it ends.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_group(command: &mut Command) -> io::Result<Process> {
        let mut process = Process::start(command.process_group(0))?;
        process.is_group = true;
        Ok(process)
    }

    /// Its process identifier.
    pub fn number(&self) -> u32 {
        self.child.id()
    }

    /// The writing end of its standard input, once, if that is a pipe.
    pub fn stdin(&mut self) -> Option<ChildStdin> {
        self.child.stdin.take()
    }

    /// The reading end of its standard output, once, if that is a pipe.
    pub fn stdout(&mut self) -> Option<ChildStdout> {
        self.child.stdout.take()
    }

    /// The reading end of its standard error, once, if that is a pipe.
    pub fn stderr(&mut self) -> Option<ChildStderr> {
        self.child.stderr.take()
    }

    /// Its exit status, once it has ended.
    pub fn ended(&mut self) -> Option<ExitStatus> {
        if self.status.is_none() {
            if self.is_group {
                self.kill_orphans();
            }
            self.status = self.child.try_wait().ok().flatten();
        }
        self.status
    }

    /// What the last call of [`Process::ended`] returned.
    pub fn status(&self) -> Option<ExitStatus> {
        self.status
    }

    /// Sends a signal to it, or to its group. Does nothing once it has ended.
    pub fn signal(&mut self, signal: Signal) {
        // Its number belongs to it only until it is reaped.
        if let (None, Ok(number)) = (self.ended(), i32::try_from(self.child.id())) {
            let _ = kill(Pid::from_raw(if self.is_group { -number } else { number }), signal);
        }
    }

    /// Waits for its end, for a limited time.
    pub fn wait(&mut self, limit: Duration) -> Option<ExitStatus> {
        let start = Instant::now();
        while self.ended().is_none() && start.elapsed() < limit {
            rest([&*self], Duration::from_millis(1));
        }
        self.status
    }

    /// Kills what the leader of a group has left behind. This has to happen before the leader is reaped, as long as the
    /// number of the group belongs to it.
    fn kill_orphans(&self) {
        let Ok(number) = i32::try_from(self.child.id()) else { return };
        let flags = WaitPidFlag::WEXITED | WaitPidFlag::WNOHANG | WaitPidFlag::WNOWAIT;
        let status = waitid(Id::Pid(Pid::from_raw(number)), flags);
        if status.is_ok_and(|status| status != WaitStatus::StillAlive) {
            let _ = kill(Pid::from_raw(-number), Signal::SIGKILL);
        }
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        if self.ended().is_none() {
            self.signal(Signal::SIGKILL);
            let _ = self.child.wait();
        }
    }
}

/// Sleeps for a time, or until one of the processes ends.
pub fn rest<'a>(processes: impl IntoIterator<Item = &'a Process>, limit: Duration) {
    let running = processes.into_iter().filter(|process| process.status.is_none());
    let mut ends: Vec<PollFd> =
        running.filter_map(|process| Some(PollFd::new(process.end.as_ref()?, PollFlags::IN))).collect();
    match Timespec::try_from(limit) {
        Ok(limit) if !ends.is_empty() => _ = poll(&mut ends, Some(&limit)),
        _ => std::thread::sleep(limit),
    }
}
