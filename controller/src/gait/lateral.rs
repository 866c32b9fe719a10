//! The lateral input u_2: the energy rule (39) on the orbit, and what the ankle does where the rule alone would be too late.
//!
//! With ξ = x + v/ω, which diverges, and ζ = x − v/ω, which decays, the energy (33) is E = −ω² ξ ζ/2. Where the feet change their roles, at
//! x = W_2/2, ξ and ζ do too. An orbit of little energy returns late, and one of none never: pushed outward, the robot must come back to
//! the slowest orbit allowed at once, by the zero-moment point at the outer edge of the sole. Pushed toward the other foot it goes over
//! early; there the exchange waits until what follows is no quicker than the quickest orbit allowed (`exchange.rs`).

use super::{GaitModel, GaitState};
use crate::pendulum::{lateral_energy, turning_point, virtual_input};

/// Period of the slowest and of the quickest orbit allowed, in periods of the gait [-].
const SLOWEST: f64 = 1.2;
const QUICKEST: f64 = 0.8;
/// Shift of the zero-moment point per distance of ξ from the slowest orbit [-]: above 1, or it would not come back.
const CAPTURE_GAIN: f64 = 3.0;
/// ζ on any orbit of interest, in widths W_2 [-]: that of the slowest orbit's turning point, and of an exchange.
const DECAYING: [f64; 2] = [0.3, 0.8];

/// The orbits between which the robot is kept.
#[derive(Clone, Copy, Debug)]
pub struct OrbitLimits {
    /// ξ ζ on the slowest [m²].
    slowest: f64,
    /// E_2 on the quickest [m²/s²].
    pub quickest: f64,
}

impl OrbitLimits {
    /// Those of a gait of this period [s] between feet `width` [m] apart.
    pub fn new(omega: f64, width: f64, period: f64) -> OrbitLimits {
        OrbitLimits {
            slowest: turning_point(omega, width, SLOWEST * period).powi(2),
            quickest: lateral_energy(omega, width, QUICKEST * period),
        }
    }
}

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
