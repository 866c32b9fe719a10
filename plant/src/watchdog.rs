//! The watchdog: what the drives do while no young command comes.
//!
//! | age of the newest command | drives |
//! |---|---|
//! | at most 10 ms | its torques |
//! | at most 100 ms | damping, τ = −D q̇ |
//! | more | off, until re-armed |
//!
//! The age counts control periods from the sensors that the command answers, in simulated time, so that the rules are the
//! same in lockstep and in real time.

/// The newest torques are kept for this long [s].
const HOLD: f64 = 0.01;
/// Then the joints are damped, until this age [s].
const DAMP: f64 = 0.1;

/// What the plant is doing; the order is that of [`STATES`](messages::wire::STATES).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Mode {
    /// No command yet: time stands still and the robot is held.
    #[default]
    Wait,
    /// Driven by a command that has just come.
    Run,
    /// Time stands still by request.
    Paused,
    /// Driven by an older command.
    Hold,
    /// Joints damped.
    Damp,
    /// Drives off until re-armed.
    Fault,
}

/// The watchdog of one run.
#[derive(Clone, Copy, Debug)]
pub struct Watchdog {
    /// Limits of the age [control periods].
    hold: u64,
    damp: u64,
    fault: bool,
}

impl Watchdog {
    /// For a control rate [Hz].
    pub fn new(rate: f64) -> Watchdog {
        let periods = |time: f64| ((time * rate).round() as u64).max(1);
        Watchdog { hold: periods(HOLD), damp: periods(DAMP), fault: false }
    }

    /// What to do with a newest command of this age; `fresh` if it came in this very period.
    pub fn judge(&mut self, age: u64, fresh: bool) -> Mode {
        self.fault |= age > self.damp;
        match age {
            _ if self.fault => Mode::Fault,
            _ if age > self.hold => Mode::Damp,
            _ if fresh => Mode::Run,
            _ => Mode::Hold,
        }
    }

    /// Ends a fault.
    pub fn rearm(&mut self) {
        self.fault = false;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_silent_controller_is_held_damped_and_switched_off_until_rearmed() {
        let mut dog = Watchdog::new(1000.0);
        let modes: Vec<Mode> = (0..=101).map(|age| dog.judge(age, age == 0)).collect();
        assert_eq!(modes[0], Mode::Run);
        assert!(modes[1..=10].iter().all(|mode| *mode == Mode::Hold));
        assert!(modes[11..=100].iter().all(|mode| *mode == Mode::Damp));
        assert_eq!(modes[101], Mode::Fault);
        assert_eq!(dog.judge(0, true), Mode::Fault, "a fault is latched");
        dog.rearm();
        assert_eq!(dog.judge(0, true), Mode::Run);
    }

    #[test]
    fn the_limits_are_times_whatever_the_rate() {
        assert_eq!(Watchdog::new(4000.0).judge(40, false), Mode::Hold);
        assert_eq!(Watchdog::new(4000.0).judge(41, false), Mode::Damp);
    }
}
