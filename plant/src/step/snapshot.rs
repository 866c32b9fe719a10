//! Snapshots: everything on which the future of a plant depends, apart from its scene.

use super::Plant;
use super::posed_state::PosedState;
use super::settings::Input;
use super::step_state::StepState;
use crate::state::State;
use serde::{Deserialize, Serialize};

/// The input and the state of a plant. The workspace and the [`Counts`](super::Counts) of evaluations are not part of it.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct PlantSnapshot {
    input: Input,
    state: StepState<State>,
}

impl Plant {
    /// The present state, to continue from it later.
    pub fn snapshot(&self) -> PlantSnapshot {
        PlantSnapshot { input: self.world.input.clone(), state: self.state.with(self.state.now.state.clone()) }
    }

    /// Returns to a state of this plant, or of another plant of the same scene. What follows has the same bits as it had then.
    pub fn restore(&mut self, snapshot: &PlantSnapshot) {
        self.world.input.clone_from(&snapshot.input);
        let now = PosedState::new(&self.world.model, snapshot.state.now.clone());
        self.state = snapshot.state.with(now);
        self.work.dynamics.set_prepared(false);
    }
}
