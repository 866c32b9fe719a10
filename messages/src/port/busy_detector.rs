//! Whether other programs compete for the processors, judged by the durations of control periods in lockstep.
//!
//! On an idle machine both sides poll, each on processors of its own. On a busy machine that is the slowest way: Linux interrupts another
//! program only at the end of its time slice, so each message costs a slice. There both sides sleep and share one processor: a side that
//! begins to wait frees it for the other side. docs/notes/busy-machine.md compares the ways. Both sides see the same control periods, so
//! both come to the same result.

use std::time::Duration;

/// A control period that takes longer than this is *long*: a side had to wait for a processor. A reader polls for as long. It is longer
/// than a recorder uses a processor, and shorter than a time slice of Linux on two processors (1.4 ms).
pub(super) const LONG_PERIOD: Duration = Duration::from_millis(1);
/// This many long control periods among the last 32 show a busy machine. A single one can be the start of a process.
const LONG_WHEN_BUSY: u32 = 3;
/// The machine is idle again after this time without a long control period. Even beside 16 other programs, long periods follow each
/// other faster.
const CALM: Duration = Duration::from_millis(200);

/// Load of the machine by other programs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Machine {
    /// A side polls, on its own processors.
    #[default]
    Idle,
    /// A side sleeps until it is notified, on the processor that both sides share.
    Busy,
}

/// Decides by the durations of control periods whether the machine is busy.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BusyDetector {
    machine: Machine,
    /// The last 32 control periods, one bit each; 1 for a long one.
    recent: u32,
    /// Busy: time without a long control period until the machine is idle. Idle: time in which the other side may still find it busy.
    remaining: Duration,
}

impl BusyDetector {
    /// Updates the load by the duration of a control period. Returns the load if it has changed.
    pub fn update(&mut self, period: Duration) -> Option<Machine> {
        let is_long = period > LONG_PERIOD;
        self.recent = self.recent << 1 | u32::from(is_long);
        self.remaining = self.remaining.saturating_sub(period);
        match self.machine {
            Machine::Idle if self.recent.count_ones() < LONG_WHEN_BUSY => return None,
            Machine::Idle => self.machine = Machine::Busy,
            Machine::Busy if is_long => {
                self.remaining = CALM;
                return None;
            }
            Machine::Busy if !self.remaining.is_zero() => return None,
            Machine::Busy => (self.machine, self.recent) = (Machine::Idle, 0),
        }
        self.remaining = CALM;
        Some(self.machine)
    }

    /// Load of the machine.
    pub fn machine(&self) -> Machine {
        self.machine
    }

    /// Whether the other side may sleep although it has just sent a message. It may find the machine idle a little later than this side.
    pub fn peer_may_sleep(&self) -> bool {
        self.machine == Machine::Busy || !self.remaining.is_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHORT: Duration = Duration::from_micros(10);
    const SLICE: Duration = Duration::from_millis(4);
    /// Short periods in [`CALM`].
    const CALM_PERIODS: u32 = (CALM.as_nanos() / SHORT.as_nanos()) as u32;

    fn periods(detector: &mut BusyDetector, period: Duration, times: u32) -> Machine {
        (0..times).for_each(|_| _ = detector.update(period));
        detector.machine()
    }

    fn busy() -> BusyDetector {
        let mut detector = BusyDetector::default();
        assert_eq!(periods(&mut detector, SLICE, LONG_WHEN_BUSY), Machine::Busy);
        detector
    }

    #[test]
    fn three_long_periods_show_a_busy_machine_and_two_or_rare_ones_do_not() {
        let mut detector = BusyDetector::default();
        for _ in 0..100 {
            assert_eq!(periods(&mut detector, SLICE, LONG_WHEN_BUSY - 1), Machine::Idle);
            assert_eq!(periods(&mut detector, SHORT, 32), Machine::Idle);
            assert!(!detector.peer_may_sleep());
        }
        assert_eq!(periods(&mut detector, SLICE, LONG_WHEN_BUSY), Machine::Busy);
        assert!(detector.peer_may_sleep());
    }

    #[test]
    fn the_machine_is_idle_again_only_after_a_time_without_long_periods() {
        let mut detector = busy();
        for _ in 0..10 {
            assert_eq!(periods(&mut detector, SHORT, CALM_PERIODS - 1), Machine::Busy);
            assert_eq!(periods(&mut detector, SLICE, 1), Machine::Busy);
        }
        assert_eq!(periods(&mut detector, SHORT, CALM_PERIODS), Machine::Idle);
    }

    #[test]
    fn a_side_that_polls_again_still_notifies_the_other_one_for_a_time() {
        let mut detector = busy();
        assert_eq!(periods(&mut detector, SHORT, CALM_PERIODS), Machine::Idle);
        assert!(detector.peer_may_sleep());
        periods(&mut detector, SHORT, CALM_PERIODS);
        assert!(!detector.peer_may_sleep());
    }
}
