//! Initial state of the controller, from the first two readings of the encoders.

use super::{ControllerModel, ControllerState};
use crate::encoder::EncoderState;
use crate::gait::GaitModel;
use crate::load::LoadState;
use crate::resume;
use crate::servo::ServoState;
use crate::support::{Joints, mirror};

impl ControllerModel {
    /// In the first two control periods: determines the supporting foot, and whether the robot is already stepping. A robot that
    /// stands still on both feet counts as supported by the left one.
    pub(super) fn detect_initial_state(&self, planner: &GaitModel, state: &mut ControllerState) {
        let side = |moving| {
            let from_left = self.chain.task(&state.encoder.angle);
            resume::right_supports(&from_left, moving, self.chain.parameters.airborne)
        };
        match state.encoder.readings {
            1 => state.right = side(false),
            2 => {
                let rate = self.encoder.unfiltered(&state.encoder);
                let right = side(true);
                let ordered = |q: &Joints| if right { mirror(q) } else { *q };
                let task = self.chain.task(&ordered(&state.encoder.angle));
                if let Some(gait) = planner.resume(&task, &ordered(&rate), state.time()) {
                    let encoder = EncoderState { rate, ..state.encoder };
                    *state = ControllerState {
                        encoder,
                        right,
                        gait: Some(gait),
                        load: LoadState::default(),
                        servo: ServoState::default(),
                        ..*state
                    };
                }
            }
            _ => (),
        }
    }
}
