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

use messages::wire::PlantState;

/// The newest torques are kept for this long [s].
const HOLD: f64 = 0.01;
/// Then the joints are damped, until this age [s].
const DAMP: f64 = 0.1;

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
    pub fn update(&mut self, age: u64, fresh: bool) -> PlantState {
        self.fault |= age > self.damp;
        match age {
            _ if self.fault => PlantState::Fault,
            _ if age > self.hold => PlantState::Damp,
            _ if fresh => PlantState::Run,
            _ => PlantState::Hold,
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
        let mut watchdog = Watchdog::new(1000.0);
        let states: Vec<PlantState> = (0..=101).map(|age| watchdog.update(age, age == 0)).collect();
        assert_eq!(states[0], PlantState::Run);
        assert!(states[1..=10].iter().all(|state| *state == PlantState::Hold));
        assert!(states[11..=100].iter().all(|state| *state == PlantState::Damp));
        assert_eq!(states[101], PlantState::Fault);
        assert_eq!(watchdog.update(0, true), PlantState::Fault, "a fault is latched");
        watchdog.rearm();
        assert_eq!(watchdog.update(0, true), PlantState::Run);
    }

    #[test]
    fn the_limits_are_times_whatever_the_rate() {
        assert_eq!(Watchdog::new(4000.0).update(40, false), PlantState::Hold);
        assert_eq!(Watchdog::new(4000.0).update(41, false), PlantState::Damp);
    }
}
