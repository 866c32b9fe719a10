//! Snapshots: everything on which the future of a controller depends, apart from its scene.

use super::{Controller, ControllerState};
use crate::error::ControllerError;
use messages::wire::Telemetry;
use serde::{Deserialize, Serialize};

/// The set-points and the state of a controller.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ControllerSnapshot {
    /// Period of two steps [s], walking speed [m/s].
    set_points: [f64; 2],
    /// Period of two steps that is walked, on the way to its set-point [s].
    period: f64,
    /// Simulated time at which the walk ends [s].
    stop_time: Option<f64>,
    state: ControllerState,
    telemetry: Telemetry,
}

impl Controller {
    /// The present state, to continue from it later.
    pub fn snapshot(&self) -> ControllerSnapshot {
        let scene = &self.model.scene;
        ControllerSnapshot {
            set_points: [scene.period, scene.speed],
            period: self.model.gait.period(),
            stop_time: scene.stop_time,
            state: self.state,
            telemetry: self.telemetry,
        }
    }

    /// Returns to a state of this controller, or of another controller of the same scene. What follows has the same bits as it had then.
    ///
    /// # Errors
    /// If the set-points are not for this robot. Then nothing changes.
    pub fn restore(&mut self, snapshot: &ControllerSnapshot) -> Result<(), ControllerError> {
        let [period, speed] = snapshot.set_points;
        self.model.scene_with(snapshot.period, 0.0)?; // on the way between two set-points that were accepted
        self.replace_set_points(Some(period), Some(speed))?;
        self.model.scene.stop_time = snapshot.stop_time;
        self.model.plan_with(snapshot.period);
        (self.state, self.telemetry) = (snapshot.state, snapshot.telemetry);
        Ok(())
    }
}
