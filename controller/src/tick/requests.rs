//! Requests while the robot walks: other set-points, and the end of the walk.

use super::Controller;
use crate::error::ControllerError;
use messages::action::GaitRequest;
use messages::scene::Gait;
use messages::wire::Verdict;
use messages::{legible, rounded_down, rounded_up};

impl Controller {
    /// Changes the set-points of the gait: period of two steps [s] and walking speed [m/s], if given.
    ///
    /// # Errors
    /// [`ControllerError::SetPoint`] if a set-point is outside the range of the robot, or another one if it would have no effect, because the
    /// robot only stands or has to stop. Then nothing changes.
    pub fn set(&mut self, period: Option<f64>, speed: Option<f64>) -> Result<(), ControllerError> {
        match self.state.set_points.stop_time.filter(|stop| self.state.time() >= *stop) {
            _ if self.model.scene.gait == Gait::Stand => Err(ControllerError::Standing),
            Some(stop) => Err(ControllerError::Stopped(stop)),
            None => self.replace_set_points(period, speed),
        }
    }

    /// Ends the walk, as if the scene's stop time were now: the robot stops at the end of the step under way. A walk that has ended stays so.
    pub fn stop(&mut self) {
        let now = self.state.time();
        let stop_time = &mut self.state.set_points.stop_time;
        *stop_time = Some(stop_time.map_or(now, |stop| stop.min(now)));
        self.planner = self.model.planner(&self.state);
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

    /// Why a walking robot of this kind refuses a request as out of range, whatever its present set-points are: what the request allows for the
    /// set-point that it does not change.
    pub fn out_of_range(&self, period: Option<f64>, speed: Option<f64>) -> ControllerError {
        let parameters = &self.model.chain.parameters;
        let ([shortest, longest], longest_step) = (parameters.periods, parameters.farthest);
        // each bound that is named is itself accepted
        let most = |bound| legible(rounded_down(bound));
        let step = format!("a step, half a period times the speed, is at most {} m", most(longest_step));
        let speeds = |period: f64| most(2.0 * longest_step / period);
        ControllerError::Request(match (period, speed) {
            (Some(period), Some(speed)) => {
                return ControllerError::SetPoint { period, speed, shortest, longest, longest_step };
            }
            (Some(period), None) => {
                let (fastest, is_possible) = (speeds(period), (shortest..=longest).contains(&period));
                let named = format!("controller.period = {} s is out of range", legible(period));
                match is_possible {
                    true => format!(
                        "{named} at the present speed: {step}, so with this period the speed must be -{fastest} to {fastest} m/s"
                    ),
                    false => format!("{named}: it must be {} to {} s", legible(rounded_up(shortest)), most(longest)),
                }
            }
            (None, speed) => {
                let speed = speed.unwrap_or_default();
                let [least, slowest] =
                    [rounded_up(shortest), rounded_down((2.0 * longest_step / speed.abs()).min(longest))];
                let named = format!("controller.speed = {} m/s is out of range", legible(speed));
                match slowest >= least {
                    true => format!(
                        "{named} at the present period: {step}, so with this speed the period must be {} to {} s",
                        legible(least),
                        legible(slowest)
                    ),
                    false => format!("{named}: {step}, so it must be -{0} to {0} m/s", speeds(least)),
                }
            }
        })
    }
}
