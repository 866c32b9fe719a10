//! The monotonic clock that both processes share, sleeping until a time on it, and waits with a limit.

use crate::log;
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::{Duration, Instant};

/// Present time of CLOCK_MONOTONIC [ns], the same in every process of this host.
pub fn now_ns() -> u64 {
    let time = ClockId::CLOCK_MONOTONIC.now().unwrap_or(TimeSpec::new(0, 0));
    time.tv_sec().unsigned_abs() * 1_000_000_000 + time.tv_nsec().unsigned_abs()
}

/// Sleeps until CLOCK_MONOTONIC reads `deadline_ns`; a signal may end the sleep early.
pub fn sleep_until(deadline_ns: u64) {
    let deadline = Duration::from_nanos(deadline_ns).into();
    // The only failure is a signal. The caller checks the clock in any case.
    let _ = clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &deadline);
}

/// A random number other than zero, for run and epoch numbers. No simulated value depends on it.
pub fn random() -> u64 {
    RandomState::new().build_hasher().finish() | 1
}

/// A wait with a time limit that reports on standard error what it waits for.
#[derive(Debug)]
pub struct Timeout {
    awaited: &'static str,
    limit: Duration,
    since: Instant,
    reported_s: u64,
}

impl Timeout {
    /// A wait for `awaited` of at most `limit`, from now on.
    pub fn new(awaited: &'static str, limit: Duration) -> Timeout {
        Timeout { awaited, limit, since: Instant::now(), reported_s: 0 }
    }

    /// Starts the wait again from zero.
    pub fn restart(&mut self) {
        (self.since, self.reported_s) = (Instant::now(), 0);
    }

    /// Whether the time is over. Each second it reports the wait on standard error.
    pub fn has_expired(&mut self) -> bool {
        let waited = self.since.elapsed();
        if waited.as_secs() > self.reported_s && waited < self.limit {
            self.reported_s = waited.as_secs();
            log(format_args!(
                "waiting for the {}: {} of {} s",
                self.awaited,
                self.reported_s,
                self.limit.as_secs_f64()
            ));
        }
        waited >= self.limit
    }
}
