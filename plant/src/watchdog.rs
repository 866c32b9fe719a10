//! The watchdog: the reaction of the drives if no recent command arrives.
//!
//! | age of the newest command | drives |
//! |---|---|
//! | at most 10 ms | its torques |
//! | at most 100 ms | damping, τ = −D q̇ |
//! | more | off, until re-armed |
//!
//! The age is counted in control periods since the sensors that the command answers, so in simulated time. The rules are therefore the
//! same in lockstep and in real time.

use messages::wire::PlantState;

/// The torques of a command are used up to this age [s].
const HOLD: f64 = 0.01;
/// After that the joints are damped up to this age [s].
const DAMP: f64 = 0.1;

/// The watchdog of one run.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Watchdog {
    /// Largest age at which the torques are used [control periods].
    hold: u64,
    /// Largest age at which the joints are damped [control periods].
    damp: u64,
    fault: bool,
}

impl Watchdog {
    /// A watchdog for this control rate [Hz].
    pub fn new(rate: f64) -> Watchdog {
        let periods = |time: f64| ((time * rate).round() as u64).max(1);
        Watchdog { hold: periods(HOLD), damp: periods(DAMP), fault: false }
    }

    /// The state for a newest command of this age. `fresh` means that it arrived in this control period.
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
    fn the_limits_are_times_at_every_control_rate() {
        assert_eq!(Watchdog::new(4000.0).update(40, false), PlantState::Hold);
        assert_eq!(Watchdog::new(4000.0).update(41, false), PlantState::Damp);
    }
}
