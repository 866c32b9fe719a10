//! Handing the robot over: torques move from those of the controller before to those of its successor, in a straight line
//! over a few control periods.
//!
//! τ = (1 − w) τ_before + w τ,  w = 1/n, 2/n, …, 1.
//!
//! A successor sees rates as differences of encoders, from its second reading on: its first torques count least.

use messages::wire::Torques;

/// What it lasts [s].
const BLEND: f64 = 0.005;

/// A hand-over, under way or not.
#[derive(Clone, Copy, Debug)]
pub struct Handover {
    /// Control periods that it takes, n.
    periods: u32,
    /// Of these, gone by.
    gone: u32,
    before: Torques,
}

impl Handover {
    /// For a control rate [Hz]; none is under way.
    pub fn new(rate: f64) -> Handover {
        let periods = ((BLEND * rate).round() as u32).max(1);
        Handover { periods, gone: periods, before: Torques::default() }
    }

    /// Begins, from these torques.
    pub fn begin(&mut self, before: Torques) {
        (self.before, self.gone) = (before, 0);
    }

    /// The torques of a control period, of which the successor wants these.
    pub fn blend(&mut self, wanted: Torques) -> Torques {
        if self.gone == self.periods {
            return wanted;
        }
        self.gone += 1;
        let w = f64::from(self.gone) / f64::from(self.periods);
        let mix = |joint: usize| (1.0 - w) * self.before.torque[joint] + w * wanted.torque[joint];
        Torques { torque: std::array::from_fn(mix) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torques_move_in_a_straight_line_and_stay_what_they_are_without_a_hand_over() {
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
    fn it_takes_as_long_at_any_rate() {
        for (rate, periods) in [(100.0, 1), (1000.0, 5), (4000.0, 20)] {
            assert_eq!(Handover::new(rate).periods, periods);
        }
    }
}
