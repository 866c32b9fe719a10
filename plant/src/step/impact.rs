//! Impact: a velocity jump at one instant.

use super::Plant;
use super::step_state::StepState;
use crate::delassus::Free;
use crate::error::PlantError;
use crate::kinematics;

impl Plant {
    /// Impact: the contact law on the velocities of all listed points, without passage of time.
    pub(super) fn impact(&mut self) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let dynamics = work.dynamics.find(&world.model, now, 0.0)?;
        let free = Free { pose: &now.pose, factor: &dynamics.factor, rate: &now.state.xdot };
        let contact = work.contacts.solve(world, &free, &mut work.touches, None, memory)?;
        record.take(contact, 1.0);
        now.state.xdot.copy_from_slice(&contact.rate);
        kinematics::velocities(&world.model, &now.state.xdot, &mut now.pose);
        Ok(())
    }
}
