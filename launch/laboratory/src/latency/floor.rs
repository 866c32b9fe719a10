//! How well the host itself keeps time: a thread that does nothing but sleep until each deadline, as cyclictest does.

use super::spread::Spread;
use messages::clock::{now_ns, sleep_until};
use sessions::realtime::{RealtimeArgs, minimize_timer_slack};
use shared::exit::{Exit, Failure};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::JoinHandle;

/// Control period that everything here is paced by [ns].
pub const PERIOD_NS: u64 = 1_000_000;

/// The thread, until it is asked what it found.
pub struct Floor {
    stop: Arc<AtomicBool>,
    thread: JoinHandle<Result<Spread, Failure>>,
}

impl Floor {
    /// Begins, scheduled as the loops beside it are, half a period apart from whatever begins at `start_ns`: both meet
    /// the same host, and neither meets the other.
    pub fn start(start_ns: u64, system: RealtimeArgs) -> Floor {
        let stop = Arc::new(AtomicBool::new(false));
        let asked = stop.clone();
        let thread = std::thread::spawn(move || {
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
        });
        Floor { stop, thread }
    }

    /// Ends it: how late it woke.
    ///
    /// # Errors
    /// If real time was required and refused.
    pub fn finish(self) -> Result<Spread, Failure> {
        self.stop.store(true, Relaxed);
        self.thread.join().unwrap_or_else(|_| Err(Failure::new(Exit::Fault, "the thread of the host's floor failed")))
    }
}

/// Sleeps until a deadline; returns by how much it was missed [ns].
pub fn late(deadline_ns: u64) -> u64 {
    let mut now = now_ns();
    while now < deadline_ns {
        sleep_until(deadline_ns);
        now = now_ns();
    }
    now - deadline_ns
}
