//! Resuming a walk: the initial state of a controller that starts while the robot is in the middle of a step.
//!
//! The gait has no clock. Its state is that of two pendulums and of the swing foot, which can be measured. Two readings of the
//! encoders are therefore enough. Only the disturbance observers and the learned corrections start from zero.

use crate::gait::{GaitModel, GaitState, Phase};
use crate::support::{Joints, Task};
use crate::swing::MinimumJerkState;

/// Whether the right foot supports the robot. `from_left` is the task seen from the left foot. The right foot supports if the left
/// one is higher by more than `airborne` [m] or, during an exchange, if the centre of gravity is nearer to the right one.
pub fn right_supports(from_left: &Task, moving: bool, airborne: f64) -> bool {
    let swing = from_left.swing();
    match swing.z {
        z if z.abs() > airborne => z < 0.0,
        _ => moving && from_left.com().y > 0.5 * swing.y,
    }
}

impl GaitModel {
    /// The gait of a robot that is stepping at a simulated time [s], from the task and the joint rates in support order; `None` if the
    /// robot is standing.
    pub fn resume(&self, task: &Task, rate: &Joints, time: f64) -> Option<GaitState> {
        let speed = task.jacobian * rate; // (27)
        let at = |k: usize| MinimumJerkState { x: task.x[k], v: speed[k], a: 0.0 };
        let [sagittal, lateral, foot] = [at(0), at(1), at(3)];
        let airborne = task.swing().z > self.parameters.airborne;
        let is_under_way = |k: usize| speed[k].abs() > self.parameters.under_way;
        let exchanging = is_under_way(1) && self.height_at(lateral) < 2.0 * self.parameters.airborne;
        let standing = self.start(task, time);
        let landed = self.stopping(&standing) && !airborne;
        if !(airborne || exchanging || landed && is_under_way(0)) {
            return None;
        }
        Some(GaitState {
            phase: if landed { Phase::Land } else { Phase::Walk },
            since: self.since_exchange(lateral),
            resumed: true,
            steps: 1,
            com: [sagittal, lateral],
            foot,
            step: self.step_length(),
            ..standing
        })
    }
}
