//! Limits that widen with the deviation of ξ_1 from the steady gait, so that a pushed robot may do more than a robot on its orbit.
//!
//! | limit | steady gait | pushed |
//! |---|---|---|
//! | torque of the new supporting foot's ankles | rises in a ramp while the foot is loaded | at once |
//! | height of the swing foot (43) | f_h | 2 f_h, because a supporting foot that tips lowers the other foot |
//! | pitch torque of the swing foot's ankle | enough for the steady motion | enough to stay level in a quick step |
//! | pitch torque of the supporting foot's ankle | for ẍ = ω²(x − p) at the sole's edge | for the planned ẍ |
//!
//! In the steady gait nothing changes. A push across does not widen any limit, so (41) holds.

use super::model::GaitModel;

impl GaitModel {
    /// Share of the widening for a deviation of ξ_1 [m]: from 0 below the range to 1 above it, without a kink.
    pub(super) fn urgency(&self, deviation: f64) -> f64 {
        let [low, high] = self.parameters.deviation;
        let r = ((deviation.abs() - low) / (high - low)).clamp(0.0, 1.0);
        r * r * (3.0 - 2.0 * r)
    }
}
