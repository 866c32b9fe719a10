//! The timing accuracy of the host itself: a thread that only sleeps until each deadline, as cyclictest does.

use super::spread::Spread;
use messages::clock::{now_ns, sleep_until};
use sessions::realtime::{RealtimeArgs, minimize_timer_slack};
use shared::exit::{Exit, Failure};
use shared::thread;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;

/// The control period [ns].
pub const PERIOD_NS: u64 = 1_000_000;

/// The running thread.
pub struct Floor {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<Spread, Failure>>,
}

impl Floor {
    /// Starts it with the scheduling of the measured loops, half a period after `start_ns`. Both then share the load of the host but do
    /// not disturb each other.
    ///
    /// # Errors
    /// If the system refuses the thread.
    pub fn start(start_ns: u64, system: RealtimeArgs) -> Result<Floor, Failure> {
        let stop = Arc::new(AtomicBool::new(false));
        let asked = stop.clone();
        let thread = thread::start(move || {
            minimize_timer_slack();
            system.apply()?;
            let mut spread = Spread::new()?;
            let mut deadline = start_ns + PERIOD_NS / 2;
            while !asked.load(Relaxed) {
                let late = late(deadline);
                spread.add_due(late, PERIOD_NS);
                deadline += (1 + late / PERIOD_NS) * PERIOD_NS;
            }
            Ok(spread)
        })?;
        Ok(Floor { stop, thread })
    }

    /// Ends it and returns how late it woke.
    ///
    /// # Errors
    /// Real-time scheduling that was required but refused.
    pub fn finish(self) -> Result<Spread, Failure> {
        self.stop.store(true, Relaxed);
        self.thread.join().unwrap_or_else(|_| Err(Failure::new(Exit::Fault, "the thread of the host's floor failed")))
    }
}

/// Sleeps until a deadline; returns the delay [ns].
pub fn late(deadline_ns: u64) -> u64 {
    let mut now = now_ns();
    while now < deadline_ns {
        sleep_until(deadline_ns);
        now = now_ns();
    }
    now - deadline_ns
}
