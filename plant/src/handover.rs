//! Hand-over between two controllers: over a few control periods the torques change linearly from those of the old controller to those
//! of its successor.
//!
//! τ = (1 − w) τ_before + w τ,  w = 1/n, 2/n, …, 1.
//!
//! A successor measures joint rates by encoder differences, so only from its second reading on. Its first torques therefore have the
//! smallest weight.

use messages::wire::Torques;

/// Duration of a hand-over [s].
const DURATION: f64 = 0.005;

/// A hand-over in progress, or none.
#[derive(Clone, Copy, Debug, serde::Serialize, serde::Deserialize)]
pub struct Handover {
    /// Number of control periods of a hand-over, n.
    periods: u32,
    /// Number of those that have passed.
    passed: u32,
    before: Torques,
}

impl Handover {
    /// No hand-over in progress, for this control rate [Hz].
    pub fn new(rate: f64) -> Handover {
        let periods = ((DURATION * rate).round() as u32).max(1);
        Handover { periods, passed: periods, before: Torques::default() }
    }

    /// Begins a hand-over from these torques.
    pub fn begin(&mut self, before: Torques) {
        (self.before, self.passed) = (before, 0);
    }

    /// The torques of a control period in which the successor commands `wanted`.
    pub fn blend(&mut self, wanted: Torques) -> Torques {
        if self.passed == self.periods {
            return wanted;
        }
        self.passed += 1;
        let w = f64::from(self.passed) / f64::from(self.periods);
        let mix = |joint: usize| (1.0 - w) * self.before.torque[joint] + w * wanted.torque[joint];
        Torques { torque: std::array::from_fn(mix) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torques_change_linearly_in_a_hand_over_and_are_unchanged_without_one() {
        let all = |torque| Torques { torque: [torque; 8] };
        let mut handover = Handover::new(1000.0);
        assert_eq!(handover.blend(all(0.1)), all(0.1));
        handover.begin(all(-10.0));
        let path: Vec<f64> = (0..7).map(|_| handover.blend(all(10.0)).torque[5]).collect();
        for (found, exact) in path.iter().zip([-6.0, -2.0, 2.0, 6.0, 10.0, 10.0, 10.0]) {
            assert!((found - exact).abs() < 1e-14, "{path:?}");
        }
    }

    #[test]
    fn the_duration_does_not_depend_on_the_control_rate() {
        for (rate, periods) in [(100.0, 1), (1000.0, 5), (4000.0, 20)] {
            assert_eq!(Handover::new(rate).periods, periods);
        }
    }
}
