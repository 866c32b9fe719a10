//! Set-points of the gait, and how a walking robot is led to new ones.
//!
//! Length and period of a step belong together: a long step in a short time is faster than either set-point asks for, and the robot falls. So
//! after each exchange of support both move by the same share of what is missing, until the length has reached its set-point:
//!
//! ```text
//!   ΔW_1 = s (W_1* − W_1)     ΔT = s (T* − T)     |ΔW_1| ≤ W_slew,  0 < s ≤ 1
//! ```
//! Thus the speed 2 W_1/T of every step is between the old and the new one. The step under way keeps its period. Only a controller that took over
//! within it has the new set-points at once: with them the robot has begun this step, and the launcher repeats them.

use super::{Controller, ControllerModel, ControllerState, SetPoints};
use crate::error::ControllerError;
use crate::gait::{GaitState, Phase};
use crate::scaled_parameters::ScaledParameters;

impl Controller {
    /// As [`Controller::set`], also if it has no effect.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`]. Then nothing changes.
    pub(super) fn replace_set_points(
        &mut self,
        period: Option<f64>,
        speed: Option<f64>,
    ) -> Result<(), ControllerError> {
        let Controller { model, state, planner, .. } = self;
        let SetPoints { period: last_period, speed: last_speed, stop_time } = state.set_points;
        let (period, speed) = (period.unwrap_or(last_period), speed.unwrap_or(last_speed));
        model.check_set_points(period, speed)?;
        let mut walking = state.gait.as_mut().filter(|gait| gait.phase == Phase::Walk);
        if let Some(resumed) = walking.take_if(|gait| gait.resumed) {
            resumed.step = 0.5 * speed * period;
        }
        if walking.is_none() {
            state.period = period;
        }
        state.set_points = SetPoints { period, speed, stop_time };
        *planner = model.planner(state);
        Ok(())
    }
}

impl ControllerModel {
    /// Checks period [s] and speed [m/s] of this robot's gait.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`].
    pub(super) fn check_set_points(&self, period: f64, speed: f64) -> Result<(), ControllerError> {
        self.chain.parameters.check_set_points(self.scene.gait, period, speed)
    }

    /// After an exchange of support: leads length and period of the steps toward the set-points. Returns whether the period changes.
    pub(super) fn lead_set_points(&self, state: &mut ControllerState, gait: &mut GaitState) -> bool {
        if gait.phase != Phase::Walk {
            return false;
        }
        let SetPoints { period, speed, .. } = state.set_points;
        let ScaledParameters { step_slew, step_slew_with_period, .. } = self.chain.parameters;
        let present = state.period;
        let most = if period == present { step_slew } else { step_slew_with_period };
        let missing = 0.5 * speed * period - gait.step;
        let change = missing.clamp(-most, most);
        gait.step += change;
        if period == present {
            return false;
        }
        let is_reached = change == missing;
        state.period = if is_reached { period } else { present + change / missing * (period - present) };
        true
    }
}
