//! The sagittal plane: where the foot lands, and where the ankle puts the zero-moment point until then.
//!
//! ```text
//!   x_t1 = x_e + W_1/2 + K (v_e − v_ref),   K = k coth(ωT/2)/ω
//!   p    = g (ξ_e − ξ_ref)/(e^(ωt) − 1),    ξ = x + v/ω
//! ```
//! (x_e, v_e) is the state predicted for the touchdown in t. k = 1 ends a deviation in one step; k = 0 mirrors the foot about the centre
//! of gravity and its step-to-step map has an eigenvalue of modulus 1: the robot falls. With g = 1 p alone would end a deviation by
//! the touchdown, and the errors of the model would shorten the steps; the sole bounds it. The paper writes only "a function of the gravity center".

use super::{GaitModel, GaitState};
use crate::pendulum::{PendulumState, Propagator};
use crate::swing::{MINIMUM_JERK_PEAK, MinimumJerkState};

/// Share of a deviation that the ankle takes, g [-].
const ANKLE_SHARE: f64 = 0.7;
/// Share of its greatest height from which on a foot is clear of the ground [-].
const CLEAR: f64 = 0.3;
/// Acceleration that the foot may have, over that of the steady gait [-].
const SPARE: f64 = 1.25;

impl GaitModel {
    /// Chooses where the foot lands, moves it on its way there, and returns the zero-moment point for the ankle [m].
    ///
    /// The prediction holds the foot's own effect γ ẍ_t, in which x_t1 occurs; it is solved for.
    pub(super) fn place_foot(&self, state: &mut GaitState, left: f64) -> f64 {
        let foot = state.foot;
        if left <= self.parameters.freeze {
            state.foot = MinimumJerkState { x: foot.x + self.h * foot.v, a: 0.0, ..foot };
            return 0.0;
        }
        let (omega, gamma) = (self.omega[0], self.swing_coupling);
        let [sagittal, _] = state.com;
        let [whole, half] = [left, 0.5 * left].map(|time| Propagator::new(omega, time));
        let free = PendulumState { x: sagittal.x, v: sagittal.v }.propagated(&whole, 0.0);
        let x_e = free.x - gamma * whole.sinh * foot.v / omega;
        let v_e = free.v - gamma * whole.cosh * foot.v;
        // Moving the foot by ΔX shifts (x_e, v_e) by these, per metre.
        let per_x = gamma * half.cosh;
        let per_v = gamma * omega * half.sinh;
        let gain = self.placement_gain;
        let step = state.step + state.corrections.step;
        let v_ref = self.touchdown_speed * step;
        let per_x_t = per_x + gain * per_v;
        let place = |x_e: f64, v_e: f64| (x_e + 0.5 * step + gain * (v_e - v_ref) - per_x_t * foot.x) / (1.0 - per_x_t);
        let zmp = if self.observer.is_disabled() {
            0.0
        } else {
            let way = place(x_e, v_e) - foot.x;
            let astray = x_e + per_x * way - 0.5 * step + (v_e + per_v * way - v_ref) / omega; // ξ_e − ξ_ref
            let growth = (omega * left.max(self.parameters.shortest_correction)).exp_m1();
            let most = self.zmp_range[0];
            (ANKLE_SHARE * astray / growth).clamp(-most, most)
        };
        let shifted = place(x_e - zmp * (whole.cosh - 1.0), v_e - zmp * omega * whole.sinh);
        state.landing = shifted.clamp(-self.parameters.farthest, self.parameters.farthest);
        // No farther than the foot gets by then.
        let coasting = foot.x + 0.5 * foot.v * left;
        let high = (self.height_at(state.com[1]) / (CLEAR * self.lift.height)).min(1.0);
        let steady = SPARE * MINIMUM_JERK_PEAK * 2.0 * step.abs() / (0.5 * self.scene.period).powi(2);
        let [near_ground, in_the_air] = self.parameters.swing_acceleration.map(|most| most.max(steady));
        let reach = (near_ground + (in_the_air - near_ground) * high) / MINIMUM_JERK_PEAK * left * left;
        let target = (state.landing - state.corrections.landing).clamp(coasting - reach, coasting + reach);
        state.foot = foot.advance_toward(target, left, self.h);
        zmp
    }
}
