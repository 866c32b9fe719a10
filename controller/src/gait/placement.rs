//! The sagittal plane: the landing position of the swing foot, and the zero-moment point until landing.
//!
//! ```text
//!   x_t1 = x_e + W_1/2 + K (v_e − v_ref),   K = k coth(ωT/2)/ω
//!   p    = d + g (ξ_e − ξ_ref)/(e^(ωt) − 1),    ξ = x + v/ω
//! ```
//! (x_e, v_e) is the state predicted at the touchdown, a time t from now. x is relative to d, the lean of the gait (`lean.rs`). With k = 1 a
//! deviation vanishes in one step. With k = 0 the foot is mirrored about the centre of gravity; then the step-to-step map has an eigenvalue of
//! modulus 1 and the robot falls. With g = 1 the zero-moment point alone would remove a deviation before touchdown, and model errors would
//! shorten the steps. The sole bounds p. The paper says only "a function of the gravity center".

use super::model::{GaitModel, GaitState};
use crate::pendulum::{PendulumState, Propagator};
use crate::swing::{MINIMUM_JERK_PEAK, MinimumJerkState};

/// g: share of a deviation that the ankle corrects [-].
const ANKLE_SHARE: f64 = 0.7;
/// Height, as a share of the largest one, above which the full acceleration of the swing foot is allowed [-].
const CLEAR: f64 = 0.3;
/// Acceleration that the swing foot may always have, over that of the steady gait [-].
const SPARE: f64 = 1.25;

impl GaitModel {
    /// Chooses the landing position, moves the planned foot by one period toward it, and returns the zero-moment point for the
    /// ankle [m].
    ///
    /// The predicted state depends on the motion of the foot through γ ẍ_t, and so on x_t1. The equation is linear in x_t1 and is
    /// solved for it.
    pub(super) fn place_foot(&self, state: &mut GaitState, left: f64) -> f64 {
        let foot = state.foot;
        if left <= self.parameters.freeze {
            state.foot = MinimumJerkState { x: foot.x + self.h * foot.v, a: 0.0, ..foot };
            return self.lean;
        }
        let (omega, gamma) = (self.omega[0], self.swing_coupling);
        let [sagittal, _] = state.com;
        let [whole, half] = [left, 0.5 * left].map(|time| Propagator::new(omega, time));
        let free = PendulumState { x: sagittal.x - self.lean, v: sagittal.v }.propagated(&whole, 0.0);
        let x_e = free.x - gamma * whole.sinh * foot.v / omega;
        let v_e = free.v - gamma * whole.cosh * foot.v;
        // Change of x_e and of v_e per metre of foot motion.
        let per_x = gamma * half.cosh;
        let per_v = gamma * omega * half.sinh;
        let gain = self.placement_gain;
        let step = state.step + state.corrections.step;
        let v_ref = self.touchdown_speed * step;
        let per_x_t = per_x + gain * per_v;
        let place = |x_e: f64, v_e: f64| (x_e + 0.5 * step + gain * (v_e - v_ref) - per_x_t * foot.x) / (1.0 - per_x_t);
        let zmp = if self.observer.is_disabled() {
            self.lean
        } else {
            let distance = place(x_e, v_e) - foot.x;
            let deviation = x_e + per_x * distance - 0.5 * step + (v_e + per_v * distance - v_ref) / omega; // ξ_e − ξ_ref
            state.urgency = self.urgency(deviation * libm::exp(-omega * left));
            let growth = libm::expm1(omega * left.max(self.parameters.shortest_correction));
            let most = self.zmp_range[0];
            (self.lean + ANKLE_SHARE * deviation / growth).clamp(-most, most)
        };
        let shift = zmp - self.lean;
        let shifted = place(x_e - shift * (whole.cosh - 1.0), v_e - shift * omega * whole.sinh);
        state.landing = shifted.clamp(-self.parameters.farthest, self.parameters.farthest);
        // The target must be within reach of the swing foot in the time left.
        let coasting = foot.x + 0.5 * foot.v * left;
        let high = (self.height_at(state.com[1]) / (CLEAR * self.swing_height.height)).min(1.0);
        let steady = SPARE * self.steady_acceleration(step);
        let [near_ground, in_the_air] = self.parameters.swing_acceleration.map(|most| most.max(steady));
        let reach = (near_ground + (in_the_air - near_ground) * high) / MINIMUM_JERK_PEAK * left * left;
        let target = (state.landing - state.corrections.landing).clamp(coasting - reach, coasting + reach);
        state.foot = foot.advance_toward(target, left, self.h);
        zmp
    }

    /// Largest acceleration of the swing foot in a steady gait with steps of length `step` [m], each of which moves it by twice that
    /// length [m/s²].
    fn steady_acceleration(&self, step: f64) -> f64 {
        MINIMUM_JERK_PEAK * 2.0 * step.abs() / (0.5 * self.scene.period).powi(2)
    }
}
