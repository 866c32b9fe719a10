//! Joint angles and rates from encoder counts.

use crate::support::Joints;
use messages::wire::Encoders;
use std::f64::consts::TAU;

/// Reads encoders: angle from the count, rate from a low-passed difference.
#[derive(Clone, Copy, Debug)]
pub struct EncoderModel {
    /// Angle of one count [rad].
    resolution: f64,
    /// Share of a new difference in the filtered rate, 1 − exp(−2π f T).
    share: f64,
    /// Control period [s].
    period: f64,
}

/// Last readings, wire order.
#[derive(Clone, Copy, Debug, Default)]
pub struct EncoderState {
    /// Angles [rad].
    pub angle: Joints,
    /// Filtered rates [rad/s].
    pub rate: Joints,
    /// Readings so far, counted to 3.
    pub readings: u32,
}

impl EncoderModel {
    /// Encoders with 2^`bits` counts a turn, read each `period` [s], the rate cut off at `cut_off` [Hz].
    pub fn new(bits: u32, period: f64, cut_off: f64) -> Self {
        EncoderModel { resolution: TAU / 2f64.powi(bits as i32), share: 1.0 - (-TAU * cut_off * period).exp(), period }
    }

    /// Takes one reading; the first has rate zero.
    pub fn read(&self, state: &mut EncoderState, encoders: &Encoders) {
        let angle = Joints::from(encoders.counts.map(|count| count as f64 * self.resolution));
        if state.readings > 0 {
            let difference = (angle - state.angle) / self.period;
            state.rate += self.share * (difference - state.rate);
        }
        *state = EncoderState { angle, readings: (state.readings + 1).min(3), ..*state };
    }

    /// After the second reading: the rates without the filter's delay, the plain difference [rad/s].
    pub fn unfiltered(&self, state: &EncoderState) -> Joints {
        state.rate / self.share
    }
}
