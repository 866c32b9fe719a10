//! Joint rates within their bounds.

use super::{ControllerModel, ControllerState};
use crate::gait::Reference;
use crate::rate::RateSolver;
use crate::support::Joints;

impl ControllerModel {
    /// Joint rates for the task rates: in closed form, or by the QP with bounds if the scene sets any.
    pub(super) fn resolve(
        &self,
        state: &ControllerState,
        solver: &RateSolver,
        plan: &Reference,
        bias: &Joints,
        rate: &Joints,
        feed_forward: &Joints,
    ) -> Option<Joints> {
        let parameters = &self.chain.parameters;
        let clamped = |low: &Joints, high: &Joints| {
            solver.rates(&plan.xdot, bias).map(|free| free.zip_zip_map(low, high, f64::clamp))
        };
        let hard = Joints::repeat(parameters.rate_limit);
        if self.scene.rate_limit.is_none() && self.scene.torque_bound.is_none() {
            return clamped(&-hard, &hard);
        }
        let mut high = Joints::repeat(self.scene.rate_limit.unwrap_or(parameters.rate_limit));
        let mut low = -high;
        if let Some(bound) = self.scene.torque_bound {
            let [least, most] = self.servo.rates_within(&state.servo, rate, feed_forward, bound);
            // If the present rate is outside both bounds, the rate bound takes precedence.
            high = most.zip_zip_map(&low, &high, f64::clamp);
            low = least.zip_zip_map(&low, &high, f64::clamp);
        }
        let bounded = solver.rates_within(&plan.xdot, bias, &low, &high);
        bounded.or_else(|| clamped(&low, &high))
    }
}
