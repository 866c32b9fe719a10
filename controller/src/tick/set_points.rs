//! Changing the set-points of the gait while the robot walks.

use super::Controller;
use crate::error::ControllerError;
use crate::gait::GaitModel;
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
        let model = &mut self.model;
        let mut scene = model.scene.clone();
        scene.period = period.unwrap_or(scene.period);
        scene.speed = speed.unwrap_or(scene.speed);
        if scene.gait == Gait::Walk {
            model.chain.parameters.check_set_points(&scene)?;
        }
        model.gait = GaitModel::new(&scene, &model.chain, &model.constants, model.servo.period);
        model.scene = scene;
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

    /// As [`Controller::set`], as the answer to a request.
    pub fn answer_set(&mut self, period: Option<f64>, speed: Option<f64>) -> Verdict {
        match self.set(period, speed) {
            Ok(()) => Verdict::Done,
            Err(ControllerError::SetPoint { .. }) => Verdict::OutOfRange,
            Err(_) => Verdict::NotServed,
        }
    }
}
