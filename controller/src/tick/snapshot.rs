//! Snapshots: everything on which the future of a controller depends, apart from its scene.

use super::{Controller, ControllerState};
use crate::error::ControllerError;
use messages::wire::Telemetry;
use serde::{Deserialize, Serialize};

/// The state of a controller.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct ControllerSnapshot {
    state: ControllerState,
    telemetry: Telemetry,
}

impl Controller {
    /// The present state, to continue from it later.
    pub fn snapshot(&self) -> ControllerSnapshot {
        ControllerSnapshot { state: self.state, telemetry: self.telemetry }
    }

    /// Returns to a state of this controller, or of another controller of the same scene. What follows has the same bits as it had then.
    ///
    /// # Errors
    /// If the set-points are not for this robot. Then nothing changes.
    pub fn restore(&mut self, snapshot: &ControllerSnapshot) -> Result<(), ControllerError> {
        let ControllerSnapshot { state, telemetry } = *snapshot;
        self.model.check_set_points(state.set_points.period, state.set_points.speed)?;
        self.model.check_set_points(state.period, 0.0)?; // on the way between two set-points that were accepted
        (self.planner, self.state, self.telemetry) = (self.model.planner(&state), state, telemetry);
        Ok(())
    }
}
