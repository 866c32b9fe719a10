//! What every measurement needs: how much of it, the other process, progress, and the wish to stop.

use super::lines::{self, Lines};
use super::peer::Peer;
use messages::session::Session;
use sessions::children::SessionCleanup;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::progress::BatchProgress;
use std::os::fd::{AsRawFd, RawFd};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Patience with the other process.
pub const PATIENCE: Duration = Duration::from_secs(3);
/// What is said when it is over.
pub const LOST: &str = "the other process of the measurement has fallen silent";

const SECOND: u64 = 1_000_000_000;

/// How much is measured.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Links take turns this often, so that whatever else the host does meets all of them.
    pub rounds: u32,
    /// Round trips of a turn that spins, and of one that sleeps; fewer, if that takes long.
    pub trips: [u32; 2],
    /// How long a turn may take at most [ns]: two that spin on one processor are slow.
    pub turn_ns: u64,
    /// Simulated time of a walk in lockstep [s], and the time that it may take [ns].
    pub walk_s: f64,
    pub walk_ns: u64,
    /// Real time of what the clock paces [s].
    pub paced_s: f64,
}

impl Plan {
    /// About a minute.
    pub const FULL: Plan =
        Plan { rounds: 10, trips: [20_000, 2_000], turn_ns: SECOND, walk_s: 14.0, walk_ns: 10 * SECOND, paced_s: 20.0 };
    /// A few seconds.
    pub const QUICK: Plan =
        Plan { rounds: 3, trips: [2_000, 200], turn_ns: SECOND / 2, walk_s: 1.0, walk_ns: SECOND, paced_s: 1.0 };
}

/// Does something on a thread of its own, with which its scheduling ends.
///
/// # Errors
/// What that fails with.
pub fn apart(job: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let ended = std::thread::scope(|scope| scope.spawn(job).join());
    ended.unwrap_or_else(|_| Err(Failure::new(Exit::Fault, "the thread of the measurement failed")))
}

/// A measurement under way.
pub struct Bench<'a> {
    pub plan: Plan,
    /// Two cache lines, and the number by which the other process, started after them, knows them.
    pub lines: &'static Lines,
    pub number: RawFd,
    pub peer: Peer,
    /// Every session that was made; cleared away once the other process has ended.
    pub sessions: Vec<SessionCleanup>,
    pub stop: &'a AtomicBool,
    pub counter: BatchProgress,
}

impl<'a> Bench<'a> {
    /// Starts the other process.
    ///
    /// # Errors
    /// If the system cannot.
    pub fn start(plan: Plan, quiet: bool, stop: &'a AtomicBool) -> Result<Bench<'a>, Failure> {
        let counter = BatchProgress::new(quiet, 0, 0, "measurements");
        let (file, lines) = lines::create()?; // open while the other process starts
        let (number, peer) = (file.as_raw_fd(), Peer::start()?);
        Ok(Bench { plan, lines, number, peer, sessions: vec![], stop, counter })
    }

    /// A session that nobody else has: `latency-PROCESS-COUNT`.
    ///
    /// # Errors
    /// Never: that is a good name.
    pub fn session(&mut self) -> Result<Session, Failure> {
        let session = Session::named(&format!("latency-{}-{}", std::process::id(), self.sessions.len()))?;
        self.sessions.push(SessionCleanup(session.clone()));
        Ok(session)
    }

    /// So many measurements are to come.
    pub fn expect(&self, count: usize) {
        self.counter.add_total(count);
    }

    /// One measurement begins.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn step(&self, what: &str) -> Result<(), Failure> {
        self.counter.set_activity(what);
        self.counter.add_done(1);
        self.stopped()
    }

    /// Whether the user wants to stop.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn stopped(&self) -> Result<(), Failure> {
        check_interrupt(self.stop)
    }

    /// A group of measurements begins.
    pub fn tell(&self, what: &str) {
        self.counter.log_without_bar(&format!("measuring {what}"));
    }
}
