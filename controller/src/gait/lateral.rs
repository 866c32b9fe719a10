//! The lateral input u_2: the energy rule (39). If this rule alone would act too late, the ankle helps.
//!
//! ξ = x + v/ω diverges and ζ = x − v/ω decays; the energy (33) is E = −ω² ξ ζ/2. At the exchange of support, x = W_2/2, the two swap
//! their roles. An orbit of small energy returns late, and one of energy zero never returns. A robot that is pushed outward must
//! therefore return at once to the slowest orbit allowed, by a zero-moment point at the outer edge of the sole. A robot that is
//! pushed toward the other foot reaches it early. Then the exchange waits until the following orbit is not quicker than the
//! quickest one allowed (`exchange.rs`).

use super::model::{GaitModel, GaitState};
use crate::pendulum::virtual_input;

/// Shift of the zero-moment point per distance of ξ from the slowest orbit [-]. Below 1 the robot would not return.
const CAPTURE_GAIN: f64 = 3.0;
/// Range of ζ in widths W_2 [-]: from the turning point of the slowest orbit to the exchange.
const DECAYING: [f64; 2] = [0.3, 0.8];

impl GaitModel {
    /// u_2 of (32) [m/s²].
    pub(super) fn lateral_input(&self, state: &GaitState) -> f64 {
        let (lateral, omega) = (state.com[1], self.omega[1]);
        let missing = self.energy_references(state)[1] - self.energies(state)[1];
        let most = self.zmp_range[1] * omega * omega;
        let orbit = virtual_input(self.scene.energy_gain, missing, lateral.v, self.parameters.fading, most); // (39)
        if self.observer.is_disabled() {
            return orbit;
        }
        let [least, greatest] = DECAYING.map(|share| share * self.width);
        let diverging = lateral.x + lateral.v / omega; // ξ
        let decaying = (lateral.x - lateral.v / omega).clamp(least, greatest); // ζ
        let outside = (self.orbit_limits.slowest / decaying - diverging).max(0.0);
        (orbit + CAPTURE_GAIN * outside * omega * omega).clamp(-most, most)
    }
}
