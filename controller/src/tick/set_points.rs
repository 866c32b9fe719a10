//! Changing the set-points of the gait while the robot walks.

use super::Controller;
use crate::error::ControllerError;
use crate::gait::GaitModel;
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

    /// As [`Controller::set`], as the answer to a request.
    pub fn answer_set(&mut self, period: Option<f64>, speed: Option<f64>) -> Verdict {
        match self.set(period, speed) {
            Ok(()) => Verdict::Done,
            Err(ControllerError::SetPoint { .. }) => Verdict::OutOfRange,
            Err(_) => Verdict::NotServed,
        }
    }
}
