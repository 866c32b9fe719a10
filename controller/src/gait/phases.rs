//! The phases before *walk*: the centre of gravity moves along minimum-jerk paths while both feet are on the ground or one is
//! about to leave it.

use super::model::{GaitModel, GaitState};
use super::reference::Reference;
use crate::scaled_parameters::ScaledParameters;
use crate::support::Task;
use crate::swing::MinimumJerkState;

impl GaitModel {
    /// Both feet are on the ground; the centre of gravity is at rest or moves as planned.
    pub(super) fn hold(&self, state: &mut GaitState, task: &Task) -> Reference {
        let load = 1.0 - self.zmp(state)[1] / self.width;
        self.reference(state, task, [0.0; 2], load.clamp(0.0, 1.0))
    }

    /// Both feet are on the ground; the centre of gravity moves to `target` [m] within `duration` [s] of the phase's start.
    pub(super) fn move_com(&self, state: &mut GaitState, task: &Task, target: [f64; 2], duration: f64) -> Reference {
        let left = duration - state.since;
        for (axis, target) in state.com.iter_mut().zip(target) {
            *axis = if left > self.parameters.freeze {
                axis.advance_toward(target, left, self.h)
            } else {
                MinimumJerkState::at_rest(axis.x)
            };
        }
        self.hold(state, task)
    }

    /// The weight leaves the swing foot; meanwhile the foot rises along a minimum-jerk path.
    pub(super) fn lift_foot(&self, state: &mut GaitState, task: &Task) -> Reference {
        let height = self.height_at(state.com[1]);
        let ScaledParameters { phases: [_, _, lift, _], unload, .. } = self.parameters;
        let r = (state.since / lift).min(1.0);
        let rise = r.powi(3) * (10.0 - 15.0 * r + 6.0 * r * r); // minimum jerk
        let rate = 30.0 * r * r * (1.0 - r).powi(2) / lift;
        let load = 1.0 - state.com[1].x / self.width * (1.0 - state.since / unload).max(0.0);
        self.reference(state, task, [height * rise, height * rate], load.clamp(0.0, 1.0))
    }
}
