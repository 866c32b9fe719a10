//! Sessions that run while a test watches them.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use messages::port::{Action, RecorderPort, ask};
use messages::session::Session;
use messages::wire::{Reply, Truth};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::read_to_string;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for anything: far more than it takes on a busy machine.
pub const LONG: Duration = Duration::from_secs(60);

/// The program with arguments, not yet started.
pub fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Waits until something holds.
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONG, "{what} did not come true");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A walk in a session of its own, and somebody who listens to it.
pub struct Running {
    pub session: Session,
    launcher: Child,
    port: Option<RecorderPort>,
    pub latest: Truth,
}

impl Running {
    /// `biped run walk` with more arguments; returns when both desks are open.
    pub fn start(name: &str, extra: &[&str]) -> Running {
        let session = Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name");
        let arguments = ["run", "walk", "--quiet", "--session", session.name()];
        let launcher = biped(&[&arguments[..], extra].concat()).spawn().expect("the program starts");
        let mut running = Running { session, launcher, port: None, latest: Truth::default() };
        let Running { session, launcher, .. } = &mut running;
        let unchanged = Action::Set { period: None, speed: None };
        eventually("an open desk", || {
            if let Some(status) = launcher.try_wait().expect("our own child") {
                let words = read_to_string(launcher.stderr.take().expect("a pipe")).expect("its last words");
                panic!("{status}: {words}");
            }
            ask(session, Action::Resume).is_ok() && ask(session, unchanged).is_ok()
        });
        running.rejoin();
        running
    }

    /// A walk in lockstep that lasts longer than any test, with nobody of ours listening.
    pub fn unheard(name: &str) -> Running {
        let mut walk = Running::start(name, &["--set", "duration=100000"]);
        walk.leave();
        walk
    }

    /// Asks, and there is an answer.
    pub fn ask(&self, what: Action) -> Reply {
        ask(&self.session, what).expect("an answer")
    }

    /// Listens until something holds.
    pub fn until(&mut self, what: &str, mut holds: impl FnMut(&Truth) -> bool) -> Truth {
        eventually(what, || {
            while let Some(truth) = self.port.as_mut().expect("listening").read().expect("reading") {
                self.latest = *truth;
                if holds(&truth) {
                    return true;
                }
            }
            false
        });
        self.latest
    }

    /// Listens until the program ends.
    pub fn hear(&mut self, mut take: impl FnMut(&Truth)) {
        eventually("an end", || {
            let ended = self.launcher.try_wait().expect("our own child").is_some();
            while let Some(truth) = self.port.as_mut().expect("listening").read().expect("reading") {
                take(&truth);
            }
            ended
        });
    }

    /// Takes everything said so far.
    pub fn drain(&mut self) {
        while let Some(truth) = self.port.as_mut().expect("listening").read().expect("reading") {
            self.latest = *truth;
        }
    }

    /// Listens again.
    pub fn rejoin(&mut self) {
        self.port = Some(RecorderPort::attach(&self.session).expect("listening"));
    }

    /// Listens no more: in lockstep nobody waits for us then.
    pub fn leave(&mut self) {
        self.port = None;
    }

    /// Number of one of the two processes.
    pub fn number(&self, role: &str) -> i32 {
        let children = format!("/proc/{0}/task/{0}/children", self.launcher.id());
        let children = std::fs::read_to_string(children).expect("children");
        let is = |pid: &&str| {
            std::fs::read_to_string(format!("/proc/{pid}/cmdline"))
                .is_ok_and(|line| line.contains(&format!("\0{role}\0")))
        };
        children.split_whitespace().find(is).expect("the role").parse().expect("a number")
    }

    /// Sends a signal to one of the two processes.
    pub fn signal(&self, role: &str, signal: Signal) {
        kill(Pid::from_raw(self.number(role)), signal).expect("a signal");
    }

    /// Waits for the end: exit code and both outputs. Nothing is left.
    pub fn wait(mut self) -> (Option<i32>, String, String) {
        self.leave();
        let errors = self.launcher.stderr.take().expect("a pipe");
        let errors = std::thread::spawn(move || read_to_string(errors).expect("its errors"));
        let words = read_to_string(self.launcher.stdout.take().expect("a pipe")).expect("its words");
        let status = self.launcher.wait().expect("the program ends");
        assert_eq!(self.session.shm_files(), Vec::<std::path::PathBuf>::new());
        (status.code(), words, errors.join().expect("read"))
    }

    /// Ends, and with it somebody who looks on.
    pub fn end_with(mut self, mut onlooker: Child) {
        self.leave();
        self.launcher.kill().expect("our own child");
        let status = onlooker.wait().expect("our own child");
        assert!(status.success(), "who looks on ends with the session: {status}");
        self.end();
    }

    /// Kills the launcher; the others end by themselves, and the last one clears up.
    pub fn end(mut self) {
        self.leave();
        self.launcher.kill().expect("our own child");
        self.launcher.wait().expect("the launcher ends");
        eventually("an empty shared memory", || self.session.shm_files().is_empty());
    }
}

/// A test that fails leaves nobody who computes on: whoever is in its session is killed, and cleared up after.
impl Drop for Running {
    fn drop(&mut self) {
        self.leave();
        let (_, _) = (self.launcher.kill(), self.launcher.wait());
        let start = Instant::now();
        while self.session.is_running() && start.elapsed() < LONG {
            let others = self.session.members().into_iter().filter(|member| *member != std::process::id());
            others.for_each(|member| _ = kill(Pid::from_raw(member as i32), Signal::SIGKILL));
            std::thread::sleep(Duration::from_millis(2));
        }
        self.session.remove_files();
    }
}
