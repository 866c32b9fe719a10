//! The monotonic clock that both processes share, and sleeping to an absolute time on it.

use crate::log;
use nix::sys::time::TimeSpec;
use nix::time::{ClockId, ClockNanosleepFlags, clock_nanosleep};
use std::hash::{BuildHasher, Hasher, RandomState};
use std::time::{Duration, Instant};

/// CLOCK_MONOTONIC now [ns]; the same in every process of this host.
pub fn now_ns() -> u64 {
    let time = ClockId::CLOCK_MONOTONIC.now().unwrap_or(TimeSpec::new(0, 0));
    time.tv_sec().unsigned_abs() * 1_000_000_000 + time.tv_nsec().unsigned_abs()
}

/// Sleeps until CLOCK_MONOTONIC reads `deadline_ns`; a signal may end the sleep early.
pub fn sleep_until(deadline_ns: u64) {
    let deadline = Duration::from_nanos(deadline_ns).into();
    // The only failure is a signal, and the caller looks at the clock anyway.
    let _ = clock_nanosleep(ClockId::CLOCK_MONOTONIC, ClockNanosleepFlags::TIMER_ABSTIME, &deadline);
}

/// A random number that is not zero, for run and epoch numbers; nothing simulated depends on it.
pub fn random() -> u64 {
    RandomState::new().build_hasher().finish() | 1
}

/// Waiting for somebody, but not for ever, and not in silence.
#[derive(Debug)]
pub struct Timeout {
    who: &'static str,
    limit: Duration,
    since: Instant,
    told: u64,
}

impl Timeout {
    /// Timeout of `limit` with `who`, starting now.
    pub fn new(who: &'static str, limit: Duration) -> Timeout {
        Timeout { who, limit, since: Instant::now(), told: 0 }
    }

    /// Somebody came: the waiting starts anew.
    pub fn renew(&mut self) {
        (self.since, self.told) = (Instant::now(), 0);
    }

    /// Whether it is over; says each second who is missing.
    pub fn is_over(&mut self) -> bool {
        let waited = self.since.elapsed();
        if waited.as_secs() > self.told && waited < self.limit {
            self.told = waited.as_secs();
            log(format_args!("waiting for the {}: {} of {} s", self.who, self.told, self.limit.as_secs_f64()));
        }
        waited >= self.limit
    }
}
