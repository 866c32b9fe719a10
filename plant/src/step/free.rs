//! The stages of a step before contact: H, b, and the motion that there would be if nothing touched.

use super::{Plant, Workspace};
use crate::error::PlantError;
use crate::kinematics::contact_column;
use crate::springs;

impl Plant {
    /// H, b and H = LᵀDL at the present pose and velocity. Springs and dampers of the joints act as they will after the
    /// time `ahead`, their forces changing with those of the step over the time `grip`; see [`springs`].
    pub(super) fn find_inertia(&mut self, grip: f64, ahead: f64) -> Result<(), PlantError> {
        self.counts.evaluations += 1;
        let Workspace { pose, composite, inertia, factor, free, .. } = &mut self.work;
        composite.inertia(&self.model, pose, inertia);
        composite.bias(&self.model, pose, &self.state.xdot, free);
        springs::stiffen(&self.model, grip, inertia);
        springs::pull(&self.model, &self.state, ahead, free);
        factor.factorize(&self.model, inertia)
    }

    /// The velocity that a step of `h` would end with if nothing touched: ẋ₋ + H⁻¹Δf_b, Δf_b = (u − b)h. (12)
    pub(super) fn predict_free_motion(&mut self, h: f64) {
        self.find_efforts();
        let Workspace { factor, free, .. } = &mut self.work;
        for effort in free.iter_mut() {
            *effort *= h; // Δf_b
        }
        factor.solve(&self.model, free);
        for (free, before) in free.iter_mut().zip(&self.state.xdot) {
            *free += before;
        }
    }

    /// u − b, with the push: all efforts but those of contact.
    pub(super) fn find_efforts(&mut self) {
        let Workspace { pose, free, column, .. } = &mut self.work;
        for bias in free.iter_mut() {
            *bias = -*bias;
        }
        for (&dof, torque) in self.model.joint_dof.iter().zip(self.applied.torque) {
            free[dof] += torque;
        }
        for push in self.settings.pushes.iter().filter(|push| push.steps.contains(&self.steps)) {
            let arm = pose.links[push.link].com;
            contact_column(&self.model, pose, push.link, &arm, &push.force, column);
            for (k, &dof) in column.iter().zip(self.model.path(push.link)) {
                free[dof] += k;
            }
        }
    }
}
