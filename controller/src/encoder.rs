//! Joint angles and rates from encoder counts.

use crate::support::Joints;
use messages::wire::Encoders;
use std::f64::consts::TAU;

/// Converts encoder counts: the angle from the count, the rate from a low-pass filtered difference.
#[derive(Clone, Copy, Debug)]
pub struct EncoderModel {
    /// Angle of one count [rad].
    resolution: f64,
    /// Weight of a new difference in the filtered rate, 1 − exp(−2π f T) [-].
    share: f64,
    /// Control period [s].
    period: f64,
}

/// Last reading, wire order.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct EncoderState {
    /// Angles [rad].
    pub angle: Joints,
    /// Filtered rates [rad/s].
    pub rate: Joints,
    /// Number of readings so far, at most 3.
    pub readings: u32,
}

impl EncoderModel {
    /// Encoders that are read once each `period` [s]. The angle of a count is `resolution` [rad], and the rate filter has the cut-off
    /// frequency `cut_off` [Hz].
    pub fn new(resolution: f64, period: f64, cut_off: f64) -> Self {
        EncoderModel { resolution, share: 1.0 - libm::exp(-TAU * cut_off * period), period }
    }

    /// Processes one reading. At the first one the rate is zero.
    pub fn read(&self, state: &mut EncoderState, encoders: &Encoders) {
        let angle = Joints::from(encoders.angles(self.resolution));
        if state.readings > 0 {
            let difference = (angle - state.angle) / self.period;
            state.rate += self.share * (difference - state.rate);
        }
        *state = EncoderState { angle, readings: (state.readings + 1).min(3), ..*state };
    }

    /// After the second reading: the unfiltered difference, which has no filter delay [rad/s].
    pub fn unfiltered(&self, state: &EncoderState) -> Joints {
        state.rate / self.share
    }
}
