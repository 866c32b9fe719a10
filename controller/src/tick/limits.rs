//! Torque limits of the joints.

use super::ControllerModel;
use crate::ankle::Ankle;
use crate::gait::{GaitState, Reference};
use crate::rate::RateSolver;
use crate::support::{Joints, Task, TaskVector};
use messages::wire::JOINTS;

/// Torque limit of the swing foot's ankle, over that of a supporting foot at rest, pitch and roll [-]. It is large enough to keep the
/// sole level when the robot is pushed.
const SWING_SHARE: [f64; 2] = [0.31, 0.8];
/// The same limit after a strong push forward or backward, which it is blended to by `GaitState::urgency` [-]. With the limit above, the
/// foot would turn during the quick step that follows.
const PUSHED_SWING_SHARE: [f64; 2] = [0.8, 0.8];
/// Share of the weight on the new supporting foot immediately after an exchange [-].
const FIRST_LOAD: f64 = 0.15;

impl ControllerModel {
    /// Torque limits in support order: those of the drives and, at the ankles, those that keep the soles flat on the ground [N·m].
    ///
    /// A foot that carries the whole weight tips when the zero-moment point reaches its edge. A foot that shares the load, and the
    /// swing foot, get a share of that torque. After an exchange the load of the new supporting foot rises from [`FIRST_LOAD`] to 1.
    /// A drive that accelerates needs its own torque in addition, because that torque does not reach the foot.
    pub(super) fn torque_limits(
        &self,
        gait: &GaitState,
        task: &Task,
        solver: &RateSolver,
        plan: &Reference,
    ) -> [Joints; 2] {
        let loaded = gait.loaded(FIRST_LOAD, self.chain.parameters.loading);
        let loaded = loaded + (1.0 - loaded) * gait.urgency;
        let drives = self.drive_torque(gait, solver, plan);
        let mut limits = [-self.torque_limit, self.torque_limit].map(Joints::repeat);
        let mut narrow = |j: usize, [low, high]: [f64; 2]| {
            [limits[0][j], limits[1][j]] =
                [low, high].map(|torque| (torque + drives[j]).clamp(-self.torque_limit, self.torque_limit));
        };
        for ankle in Ankle::BOTH {
            let k = ankle.axis();
            let (edge, omega) = (self.constants.sole_edge[k], self.constants.omega[k]);
            let level = edge * (self.chain.total_mass * self.gravity);
            let at_rest = |share: f64| [-level * share, level * share];
            let (stance, swing) = if plan.load < 1.0 {
                (at_rest(plan.load), at_rest(1.0 - plan.load))
            } else {
                let swing = SWING_SHARE[k] + (PUSHED_SWING_SHARE[k] - SWING_SHARE[k]) * gait.urgency;
                // The acceleration of a pendulum with the zero-moment point p. In the sagittal plane of a pushed robot, the planned one.
                let acceleration = |p: f64| {
                    let free = omega * omega * (task.x[k] - p);
                    free + [gait.urgency, 0.0][k] * (plan.acceleration[k] - free)
                };
                (self.chain.ankle_range(task, ankle, self.gravity, loaded * edge, acceleration), at_rest(swing))
            };
            narrow(ankle.joint(), stance);
            narrow(JOINTS - 1 - ankle.joint(), swing);
        }
        limits
    }

    /// J_r q̈: the torque that accelerates the drives as planned [N·m]. It is part of the feed-forward, which the paper does not have.
    fn drive_torque(&self, gait: &GaitState, solver: &RateSolver, plan: &Reference) -> Joints {
        if !self.scene.feed_forward {
            return Joints::zeros();
        }
        let [a_1, a_2] = plan.acceleration;
        let xddot = TaskVector::from([a_1, a_2, 0.0, gait.foot.a, 0.0, 0.0, 0.0]);
        solver.rates(&xddot, &Joints::zeros()).map_or_else(Joints::zeros, |qddot| self.drive_inertia * qddot)
    }
}
