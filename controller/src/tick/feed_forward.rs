//! Feed-forward torques.

use super::{ControllerModel, ControllerState};
use crate::ankle::Ankle;
use crate::gait::Reference;
use crate::support::{Joints, Task, mirror};
use messages::wire::JOINTS;

impl ControllerModel {
    /// Torques that carry the weight and accelerate the centre of gravity as planned, from kinematics alone [N·m]:
    /// τ = M (g J_c3ᵀ + a_1 J_c1ᵀ + a_2 J_c2ᵀ) for a fixed supporting foot, shared between the feet by the load. If one foot carries the
    /// whole weight, its ankle gets the torque of the planned zero-moment point (`ankle.rs`), which includes the rotation of the
    /// links.
    ///
    /// If both feet carry weight, the distribution of the load balances the robot sideways. Roll torques as for two separate feet
    /// would press the feet apart up to the friction limit. So the roll torque of the swing foot's ankle is zero, and that of the
    /// supporting foot's ankle is the remainder, M g (x_zmp − (1 − load) W_2).
    pub(super) fn feed_forward(&self, state: &ControllerState, task: &Task, plan: &Reference) -> Joints {
        if !self.scene.feed_forward {
            return Joints::zeros();
        }
        let [a_1, a_2] = plan.acceleration;
        let carry = |task: &Task, a_2: f64| {
            let row = |k: usize| task.jacobian.row(k).transpose();
            self.chain.total_mass * (self.gravity * row(2) + a_1 * row(0) + a_2 * row(1))
        };
        let mut stance = carry(task, a_2);
        if plan.load >= 1.0 {
            for ankle in Ankle::BOTH {
                let k = ankle.axis();
                stance[ankle.joint()] =
                    self.chain.ankle_torque(task, ankle, self.gravity, plan.zmp[k], plan.acceleration[k]);
            }
            return stance;
        }
        // Axis 2 of the other foot's support frame points the opposite way.
        let other = self.chain.task(&mirror(&state.in_support_order(&state.encoder.angle)));
        let mut shared = plan.load * stance + (1.0 - plan.load) * mirror(&carry(&other, -a_2));
        let off_balance = plan.zmp[1] - (1.0 - plan.load) * self.chain.leg_width();
        shared[0] = -self.chain.total_mass * self.gravity * off_balance;
        shared[JOINTS - 1] = 0.0;
        shared
    }
}
