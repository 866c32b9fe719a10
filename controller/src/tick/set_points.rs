//! Changing the gait while the robot walks: other set-points, and the end of the walk.
//!
//! Length and period of a step belong together: a long step in a short time is faster than either set-point asks for, and the robot falls. So
//! after each exchange of support both move by the same share of what is missing, until the length has reached its set-point:
//!
//! ```text
//!   ΔW_1 = s (W_1* − W_1)     ΔT = s (T* − T)     |ΔW_1| ≤ W_slew,  0 < s ≤ 1
//! ```
//! Thus the speed 2 W_1/T of every step is between the old and the new one. The step under way keeps its period. Only a controller that took over
//! within it has the new set-points at once: with them the robot has begun this step, and the launcher repeats them.

use super::{Controller, ControllerModel};
use crate::error::ControllerError;
use crate::gait::{GaitModel, GaitState, Phase};
use crate::scaled_parameters::ScaledParameters;
use messages::action::GaitRequest;
use messages::legible;
use messages::scene::{ControllerScene, Gait};
use messages::wire::Verdict;

impl Controller {
    /// Changes the set-points of the gait: period of two steps [s] and walking speed [m/s], if given.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`] if a set-point is outside the range of the robot, or another one if it would have no effect, because the
    /// robot only stands or has to stop. Then nothing changes.
    pub fn set(&mut self, period: Option<f64>, speed: Option<f64>) -> Result<(), ControllerError> {
        let ControllerScene { gait, stop_time, .. } = self.model.scene;
        match stop_time.filter(|stop| self.state.time() >= *stop) {
            _ if gait == Gait::Stand => Err(ControllerError::Standing),
            Some(stop) => Err(ControllerError::Stopped(stop)),
            None => self.replace_set_points(period, speed),
        }
    }

    /// As [`Controller::set`], also if it has no effect.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`]. Then nothing changes.
    pub(super) fn replace_set_points(
        &mut self,
        period: Option<f64>,
        speed: Option<f64>,
    ) -> Result<(), ControllerError> {
        let Controller { model, state, .. } = self;
        let scene = model.scene_with(period.unwrap_or(model.scene.period), speed.unwrap_or(model.scene.speed))?;
        let mut walking = state.gait.as_mut().filter(|gait| gait.phase == Phase::Walk);
        if let Some(resumed) = walking.take_if(|gait| gait.resumed) {
            resumed.step = 0.5 * scene.speed * scene.period;
        }
        let period = if walking.is_some() { model.gait.period() } else { scene.period };
        model.scene = scene;
        model.plan_with(period);
        Ok(())
    }

    /// Why a walking robot of this kind refuses a request as out of range, whatever its present set-points are: what the request allows for the
    /// set-point that it does not change.
    pub fn out_of_range(&self, period: Option<f64>, speed: Option<f64>) -> ControllerError {
        let parameters = &self.model.chain.parameters;
        let ([shortest, longest], longest_step) = (parameters.periods, parameters.farthest);
        let step = format!("a step, half a period times the speed, is at most {longest_step:.3} m");
        ControllerError::Request(match (period, speed) {
            (Some(period), Some(speed)) => {
                return ControllerError::SetPoint { period, speed, shortest, longest, longest_step };
            }
            (Some(period), None) => {
                let (fastest, is_possible) = (2.0 * longest_step / period, (shortest..=longest).contains(&period));
                let named = format!("controller.period = {} s is out of range", legible(period));
                match is_possible {
                    true => format!(
                        "{named} at the present speed: {step}, so with this period the speed must be -{fastest:.3} to {fastest:.3} m/s"
                    ),
                    false => format!("{named}: it must be {shortest:.2} to {longest:.2} s"),
                }
            }
            (None, speed) => {
                let speed = speed.unwrap_or_default();
                let (slowest, fastest) =
                    ((2.0 * longest_step / speed.abs()).min(longest), 2.0 * longest_step / shortest);
                let named = format!("controller.speed = {} m/s is out of range", legible(speed));
                match slowest >= shortest {
                    true => format!(
                        "{named} at the present period: {step}, so with this speed the period must be {shortest:.2} to {slowest:.2} s"
                    ),
                    false => format!("{named}: {step}, so it must be -{fastest:.3} to {fastest:.3} m/s"),
                }
            }
        })
    }

    /// Ends the walk, as if the scene's stop time were now: the robot stops at the end of the step under way. A walk that has ended stays so.
    pub fn stop(&mut self) {
        let Controller { model, state, .. } = self;
        let now = state.time();
        model.scene.stop_time = Some(model.scene.stop_time.map_or(now, |stop| stop.min(now)));
        model.plan_with(model.gait.period());
    }

    /// Carries out a request.
    ///
    /// # Errors
    /// As [`Controller::set`].
    pub fn carry_out(&mut self, request: GaitRequest) -> Result<(), ControllerError> {
        match request {
            GaitRequest::Set { period, speed } => self.set(period, speed),
            GaitRequest::Stop => {
                self.stop();
                Ok(())
            }
        }
    }

    /// As [`Controller::carry_out`], with the answer that goes back to the sender of the request.
    pub fn answer(&mut self, request: GaitRequest) -> Verdict {
        match self.carry_out(request) {
            Ok(()) => Verdict::Done,
            Err(error) if error.is_without_effect() => Verdict::NoEffect,
            Err(_) => Verdict::OutOfRange,
        }
    }
}

impl ControllerModel {
    /// The scene with this period [s] and speed [m/s].
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`].
    pub(super) fn scene_with(&self, period: f64, speed: f64) -> Result<ControllerScene, ControllerError> {
        let scene = ControllerScene { period, speed, ..self.scene.clone() };
        if scene.gait == Gait::Walk {
            self.chain.parameters.check_set_points(&scene)?;
        }
        Ok(scene)
    }

    /// After an exchange of support: leads length and period of the steps toward the set-points.
    pub(super) fn lead_set_points(&mut self, gait: &mut GaitState) {
        if gait.phase != Phase::Walk {
            return;
        }
        let ControllerScene { period, speed, .. } = self.scene;
        let ScaledParameters { step_slew, step_slew_with_period, .. } = self.chain.parameters;
        let present = self.gait.period();
        let most = if period == present { step_slew } else { step_slew_with_period };
        let missing = 0.5 * speed * period - gait.step;
        let change = missing.clamp(-most, most);
        gait.step += change;
        if period != present {
            let is_reached = change == missing;
            self.plan_with(if is_reached { period } else { present + change / missing * (period - present) });
        }
    }

    /// Plans with the set-points that were last asked for, but with this period of two steps [s].
    pub(super) fn plan_with(&mut self, period: f64) {
        let scene = ControllerScene { period, ..self.scene.clone() };
        self.gait = GaitModel::new(&scene, &self.chain, &self.constants, self.servo.period);
    }
}
