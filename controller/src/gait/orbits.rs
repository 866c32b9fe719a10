//! The lateral orbits between which the gait keeps the robot.

use crate::pendulum::{lateral_energy, turning_point};

/// Period of the slowest orbit that is allowed, over the period of the gait [-].
const SLOWEST: f64 = 1.2;
/// Period of the quickest orbit that is allowed, over the period of the gait [-].
const QUICKEST: f64 = 0.8;

/// The slowest and the quickest lateral orbit that are allowed.
#[derive(Clone, Copy, Debug)]
pub struct OrbitLimits {
    /// ξ ζ on the slowest orbit [m²].
    pub slowest: f64,
    /// E_2 on the quickest orbit [m²/s²].
    pub quickest: f64,
}

impl OrbitLimits {
    /// Limits for a gait of this period [s] with feet `width` [m] apart.
    pub fn new(omega: f64, width: f64, period: f64) -> OrbitLimits {
        OrbitLimits {
            slowest: turning_point(omega, width, SLOWEST * period).powi(2),
            quickest: lateral_energy(omega, width, QUICKEST * period),
        }
    }
}
