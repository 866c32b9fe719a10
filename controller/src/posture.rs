//! Postures: the joint angles of a task.

use crate::rate;
use crate::support::{Chain, Joints, TaskVector};

/// Iterations of Newton's method for a posture. The limit only ends a search that has no solution.
const MAX_ITERATIONS: usize = 50;
/// Residual of the task at which a posture is found: rounding of lengths of .1 m and angles [m, rad].
const TASK_TOLERANCE: f64 = 1e-12;
/// Pitch of the swing foot at which a posture is found [rad].
const PITCH_TOLERANCE: f64 = 1e-9;

/// Joint angles at which the task is `target`, by Newton's method from `guess`; `None` if it does not converge.
pub fn solve_posture(chain: &Chain, target: &TaskVector, guess: &Joints) -> Option<Joints> {
    let mut s = *guess;
    for _ in 0..MAX_ITERATIONS {
        let task = chain.task(&s);
        let miss = target - task.x;
        if miss.amax() < TASK_TOLERANCE && task.swing_pitch.abs() < PITCH_TOLERANCE {
            return Some(s);
        }
        s += rate::resolve(&task.jacobian, &miss, &rate::bias(task.swing_pitch / rate::LEVEL_GAIN))?;
    }
    None
}
