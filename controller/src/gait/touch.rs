//! A swing foot that meets the ground too early stays at that height until the exchange.
//!
//! The foot follows (43), which knows only level ground. On a higher place it would move down further and lift the robot off its
//! supporting foot. So the foot keeps its height if it carries most of the weight (`load.rs`) while the kinematics say that it is in the
//! air. On level ground a foot in the air carries nothing, and nothing changes.

use super::model::{GaitModel, GaitState};
use crate::support::Task;
use messages::scene::Sagittal;

/// Load at which a foot has touched the ground, over the weight of the robot: it carries more than the supporting foot [-]. Unknown loads
/// and coarse encoders disturb the estimate. With .35 a foot in the air seems to touch if the trunk carries 6 kg more.
const TOUCH: f64 = 0.5;

impl GaitModel {
    /// Height and rate of the swing foot [m, m/s]: those of (43), `lift`, or the height at which it has touched the ground in this step.
    /// `load` is that of the swing foot, over the weight of the robot. Under the paper's sagittal rule the foot always follows (43).
    pub(super) fn above_ground(&self, state: &mut GaitState, task: &Task, load: f64, lift: [f64; 2]) -> [f64; 2] {
        let height = task.swing().z;
        let descends = self.scene.sagittal == Sagittal::FootPlacement && state.com[1].v > 0.0;
        if descends && load > TOUCH && height > self.parameters.airborne {
            state.ground = state.ground.or(Some(height));
        }
        match state.ground {
            Some(ground) if lift[0] < ground => [ground, 0.0],
            _ => lift,
        }
    }
}
