//! The context of all measurements: their extent, the other process, the progress display and the stop flag.

use super::lines::{self, Lines};
use super::second_process::SecondProcess;
use messages::session::Session;
use sessions::children::SessionCleanup;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::progress::BatchProgress;
use shared::thread;
use std::os::fd::{AsRawFd, RawFd};
use std::sync::atomic::AtomicBool;

const SECOND: u64 = 1_000_000_000;

/// The extent of the measurement.
#[derive(Clone, Copy, Debug)]
pub struct Plan {
    /// Number of rounds. All links are measured in each round, so that other load of the host affects all of them.
    pub rounds: u32,
    /// Round trips of a measurement that spins and of one that sleeps; fewer if it takes long.
    pub trips: [u32; 2],
    /// Time limit of a measurement [ns]: two processes that spin on one processor are slow.
    pub turn_ns: u64,
    /// Simulated time of a walk in lockstep [s], and its time limit [ns].
    pub walk_s: f64,
    pub walk_ns: u64,
    /// Duration of a run paced by the clock [s].
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

/// Runs a function on a new thread. Its scheduling settings end with this thread.
///
/// # Errors
/// The failure of the function.
pub fn on_new_thread(job: impl FnOnce() -> Result<(), Failure> + Send) -> Result<(), Failure> {
    let ended = std::thread::scope(|scope| Ok::<_, Failure>(thread::start_scoped(scope, job)?.join()))?;
    ended.unwrap_or_else(|_| Err(Failure::new(Exit::Fault, "the thread of the measurement failed")))
}

/// A measurement in progress.
pub struct Bench<'a> {
    pub plan: Plan,
    /// Two shared cache lines, and the file number by which the other process, started later, opens them.
    pub lines: &'static Lines,
    pub number: RawFd,
    pub peer: SecondProcess,
    /// All sessions of the measurement; they are removed when the other process has ended.
    pub sessions: Vec<SessionCleanup>,
    pub stop: &'a AtomicBool,
    pub counter: BatchProgress,
}

impl<'a> Bench<'a> {
    /// Starts the other process.
    ///
    /// # Errors
    /// A system that cannot start it.
    pub fn start(plan: Plan, quiet: bool, stop: &'a AtomicBool) -> Result<Bench<'a>, Failure> {
        let counter = BatchProgress::new(quiet, 0, 0, "measurements");
        let (file, lines) = lines::create()?; // open while the other process starts
        let (number, peer) = (file.as_raw_fd(), SecondProcess::start()?);
        Ok(Bench { plan, lines, number, peer, sessions: vec![], stop, counter })
    }

    /// A unique session: `latency-PROCESS-COUNT`.
    ///
    /// # Errors
    /// None: the name is valid.
    pub fn session(&mut self) -> Result<Session, Failure> {
        let session = Session::named(&format!("latency-{}-{}", std::process::id(), self.sessions.len()))?;
        self.sessions.push(SessionCleanup(session.clone()));
        Ok(session)
    }

    /// Sets the number of measurements.
    pub fn expect(&self, count: usize) {
        self.counter.add_total(count);
    }

    /// Starts a measurement.
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

    /// Starts a group of measurements.
    pub fn begin_group(&self, what: &str) {
        self.counter.log_without_bar(&format!("measuring {what}"));
    }
}
