//! A running session that a test observes.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use messages::port::{Action, GaitRequest, RecorderPort, ask};
use messages::session::Session;
use messages::wire::{Reply, Truth};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::io::read_to_string;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// Longest wait for any condition: far more than a busy machine needs.
pub const LONG: Duration = Duration::from_secs(60);

/// The program with arguments, ready to be started.
pub fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Waits until a condition holds.
pub fn eventually(what: &str, mut holds: impl FnMut() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < LONG, "{what}: not within {LONG:?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// A walk in its own session, with an observer.
pub struct Running {
    pub session: Session,
    launcher: Child,
    port: Option<RecorderPort>,
    pub latest: Truth,
}

impl Running {
    /// Starts `biped run walk` with more arguments, and waits until both control services are open.
    pub fn start(name: &str, extra: &[&str]) -> Running {
        let session = Session::named(&format!("test-{}-{name}", std::process::id())).expect("a good name");
        let arguments = ["run", "walk", "--quiet", "--session", session.name()];
        let launcher = biped(&[&arguments[..], extra].concat()).spawn().expect("the program starts");
        let mut running = Running { session, launcher, port: None, latest: Truth::default() };
        let Running { session, launcher, .. } = &mut running;
        let unchanged = Action::Gait(GaitRequest::Set { period: None, speed: None });
        eventually("open control services", || {
            if let Some(status) = launcher.try_wait().expect("our own child") {
                let words = read_to_string(launcher.stderr.take().expect("a pipe")).expect("its last words");
                panic!("{status}: {words}");
            }
            ask(session, Action::Resume).is_ok() && ask(session, unchanged).is_ok()
        });
        running.observe();
        running
    }

    /// A lockstep walk that lasts longer than any test, without an observer.
    pub fn unobserved(name: &str) -> Running {
        let mut walk = Running::start(name, &["--set", "duration=100000"]);
        walk.stop_observing();
        walk
    }

    /// Sends a request and returns the reply.
    pub fn ask(&self, what: Action) -> Reply {
        ask(&self.session, what).expect("an answer")
    }

    /// Observes until a condition holds, and returns the truth then.
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

    /// Observes until the launcher exits.
    pub fn until_exit(&mut self, mut take: impl FnMut(&Truth)) {
        eventually("the end of the run", || {
            let ended = self.launcher.try_wait().expect("our own child").is_some();
            while let Some(truth) = self.port.as_mut().expect("listening").read().expect("reading") {
                take(&truth);
            }
            ended
        });
    }

    /// Receives all truths that are waiting.
    pub fn drain(&mut self) {
        while let Some(truth) = self.port.as_mut().expect("listening").read().expect("reading") {
            self.latest = *truth;
        }
    }

    /// Starts observing.
    pub fn observe(&mut self) {
        self.port = Some(RecorderPort::attach(&self.session).expect("listening"));
    }

    /// Stops observing. In lockstep the plant waits for every observer, but not for one that has left.
    pub fn stop_observing(&mut self) {
        self.port = None;
    }

    /// Process ID of the plant or the controller.
    pub fn pid(&self, role: &str) -> i32 {
        let children = format!("/proc/{0}/task/{0}/children", self.launcher.id());
        let children = std::fs::read_to_string(children).expect("children");
        let is = |pid: &&str| {
            std::fs::read_to_string(format!("/proc/{pid}/cmdline"))
                .is_ok_and(|line| line.contains(&format!("\0{role}\0")))
        };
        children.split_whitespace().find(is).expect("the role").parse().expect("a number")
    }

    /// Sends a signal to the plant or the controller.
    pub fn signal(&self, role: &str, signal: Signal) {
        kill(Pid::from_raw(self.pid(role)), signal).expect("a signal");
    }

    /// Waits for the end of the run, and asserts that no session files are left. Returns exit code, standard output and standard error.
    pub fn wait(mut self) -> (Option<i32>, String, String) {
        self.stop_observing();
        let errors = self.launcher.stderr.take().expect("a pipe");
        let errors = std::thread::spawn(move || read_to_string(errors).expect("its errors"));
        let words = read_to_string(self.launcher.stdout.take().expect("a pipe")).expect("its words");
        let status = self.launcher.wait().expect("the program ends");
        assert_eq!(self.session.shm_files(), Vec::<std::path::PathBuf>::new());
        (status.code(), words, errors.join().expect("read"))
    }

    /// Kills the launcher, and asserts that an observer process exits with the session.
    pub fn end_with(mut self, mut observer: Child) {
        self.stop_observing();
        self.launcher.kill().expect("our own child");
        let status = observer.wait().expect("our own child");
        assert!(status.success(), "an observer exits with the session: {status}");
        self.end();
    }

    /// Kills the launcher. The other processes exit by themselves, and the last one removes the session files.
    pub fn end(mut self) {
        self.stop_observing();
        self.launcher.kill().expect("our own child");
        self.launcher.wait().expect("the launcher ends");
        eventually("an empty shared memory", || self.session.shm_files().is_empty());
    }
}

/// After a failed test, all processes of the session are killed and its files removed.
impl Drop for Running {
    fn drop(&mut self) {
        self.stop_observing();
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
