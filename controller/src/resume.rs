//! Taking over a robot that is already on its way: a controller that was started anew amid a step.
//!
//! The gait is autonomous: it has no clock, only the state of two pendulums and of a foot. All of that can be measured, so
//! two readings of the encoders suffice to go on; what is lost is what was learned (observers, trim of the landing).

use crate::gait::{GaitModel, GaitState, Phase};
use crate::support::{Joints, Task};
use crate::swing::MinimumJerkState;

/// Whether the right foot carries, seen from the left: it does if the left one is in the air, beyond `airborne` [m], or, amid an exchange, if the
/// centre of gravity is nearer to it.
pub fn right_supports(from_left: &Task, moving: bool, airborne: f64) -> bool {
    let swing = from_left.swing();
    match swing.z {
        z if z.abs() > airborne => z < 0.0,
        _ => moving && from_left.com().y > 0.5 * swing.y,
    }
}

impl GaitModel {
    /// The gait of a robot that is stepping, from its task and joint rates in the order of its support; `None` if it is
    /// standing.
    pub fn resume(&self, task: &Task, rate: &Joints) -> Option<GaitState> {
        let speed = task.jacobian * rate; // (27)
        let at = |k: usize| MinimumJerkState { x: task.x[k], v: speed[k], a: 0.0 };
        let [sagittal, lateral, foot] = [at(0), at(1), at(3)];
        let airborne = task.swing().z > self.parameters.airborne;
        let exchanging =
            speed[1].abs() > self.parameters.under_way && self.height_at(lateral) < 2.0 * self.parameters.airborne;
        if !airborne && !exchanging {
            return None;
        }
        Some(GaitState {
            phase: Phase::Walk,
            since: self.since_exchange(lateral),
            steps: 1,
            com: [sagittal, lateral],
            foot,
            step: self.step_length(),
            ..self.start(task)
        })
    }
}
