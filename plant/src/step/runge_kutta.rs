//! Explicit Runge-Kutta methods on positions that include a quaternion.
//!
//! A step starts from (x0, ẋ0). Its stages use the displacement d from x0, x = x0 ⊕ d, a vector with one entry per degree of freedom. For
//! an orientation, d is a rotation vector with the rate dexp⁻¹_d(w). So every method keeps its order, the quaternion keeps unit length, and
//! a uniform rotation is exact.
//!
//! # Source
//! Munthe-Kaas (1999); Hairer, Lubich & Wanner, *Geometric Numerical Integration*, IV.8. Hairer, Nørsett & Wanner, *Solving Ordinary
//! Differential Equations I*, II.1 and II.5.

use super::Plant;
use super::stages::{RK4, Tableau};
use super::step_state::StepState;
use super::workspace::Workspace;
use crate::delassus::Free;
use crate::error::PlantError;

impl Plant {
    /// Integrates without contact by the classical method. If a point is then below the ground, applies one impulse of the contact law at
    /// the end of the step.
    ///
    /// The impulse stands for forces that acted during the whole step, so half of its velocity change counts for the position: x₊ = x_f ⊕
    /// ½h(ẋ₊ − ẋ_f). A body at rest falls by ½gh² within the step and is lifted by the same amount, so it neither sinks nor creeps. A
    /// landing is stopped up to ½h|ẋ| too low or too high. Motion with lasting contact is first order, because the stages ignore the
    /// ground.
    pub(super) fn rk4(&mut self, h: f64) -> Result<(), PlantError> {
        self.work.start.copy(&self.state.now.state);
        self.integrate(&RK4, h)?; // no contact is active, so forces exist
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let touches = work.touches.find_penetrating(world, &now.pose, &now.state.xdot, h);
        if touches.list.is_empty() {
            return Ok(());
        }
        let dynamics = work.dynamics.find(&world.model, now, 0.0)?;
        let free = Free { pose: &now.pose, factor: &dynamics.factor, rate: &now.state.xdot };
        let contact = work.contacts.solve(world, &free, touches, None, memory)?;
        record.take(contact, 1.0);
        now.state.xdot.copy_from_slice(&contact.rate);
        now.state.displace(&world.model, |i| 0.5 * h * contact.change[i]);
        now.update_pose(world)
    }

    /// Integrates from the start of the step to its end, with the forces of the active contacts. Returns whether forces exist. If not, the
    /// state is that of the stage without them.
    pub(super) fn integrate(&mut self, tableau: &Tableau, h: f64) -> Result<bool, PlantError> {
        let Plant { world, state: StepState { now, memory, event_contacts, record, .. }, work, .. } = self;
        let Workspace { start, remembered, stages, dynamics, free, touches, contacts, .. } = work;
        if now.state != *start {
            // a trial before went too far: its contacts may have opened
            now.state.copy(start);
            now.update_pose(world)?;
            memory.copy(remembered);
        }
        stages.contact_change.fill(0.0);
        for (stage, (weight, b)) in tableau.record.iter().zip(tableau.b).enumerate() {
            if stage > 0 {
                let (displacement, velocity) = stages.combine(start, tableau.a[stage - 1], h);
                now.set_displaced(world, start, |i| displacement[i], velocity)?;
            }
            let dynamics = dynamics.find(&world.model, now, 0.0)?;
            let free = free.acceleration(world, now, dynamics); // H⁻¹(u − b)
            let touches = touches.find_active(world, &now.pose, event_contacts);
            let forces = contacts.forces(world, &free, &dynamics.composite, touches, event_contacts, memory)?;
            let Some(contact) = forces else { return Ok(false) };
            record.take(contact, weight * h);
            stages.contact_change.iter_mut().zip(&contact.change).for_each(|(sum, change)| *sum += b * h * change);
            stages.take(stage, &world.model, &now.state, &contact.rate);
        }
        let (displacement, velocity) = stages.combine(start, tableau.b, h);
        now.set_displaced(world, start, |i| displacement[i], velocity)?;
        Ok(true)
    }
}
