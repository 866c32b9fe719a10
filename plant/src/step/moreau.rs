//! The method of Moreau and Jean with θ = ½: mean forces over the step, second order.

use super::Plant;
use super::step_state::StepState;
use super::workspace::Means;
use crate::delassus::Free;
use crate::error::PlantError;

impl Plant {
    /// ẋ₊ = ẋ₋ + h·½(a(x, ẋ₋) + a(x*, ẋ*)) + H⁻¹KΔf, x₊ = x + ½h(ẋ₋ + ẋ₊), with the contact law at the end of the step.
    ///
    /// a = H⁻¹(u − b). The predicted end (x*, ẋ*) is the result of a step with the forces of its beginning alone, contact included. H, K
    /// and gaps are evaluated there. This is one iteration of the implicit method.
    ///
    /// # Source
    /// Moreau (1988); Jean (1999); Acary & Brogliato, *Numerical Methods for Nonsmooth Dynamical Systems* (2008), 10.1.
    pub(super) fn moreau_jean(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        work.start.copy(&now.state);
        let (start, Means { start_change, velocity }) = (&work.start, &mut work.means);
        let dynamics = work.dynamics.find(&world.model, now, 0.0)?;
        let free = work.free.motion(world, now, dynamics, h);
        for ((start_change, free), before) in start_change.iter_mut().zip(free.rate).zip(&start.xdot) {
            *start_change = free - before; // h a(x, ẋ₋)
        }
        let touches = work.touches.find(world, now, free.rate, h, memory);
        let contact = work.contacts.solve(world, &free, touches, None, memory)?;
        now.set_displaced(world, start, |i| 0.5 * h * (start.xdot[i] + contact.rate[i]), &contact.rate)?; // (x*, ẋ*)
        let dynamics = work.dynamics.find(&world.model, now, 0.0)?;
        let free = work.free.motion(world, now, dynamics, h);
        let ends = free.rate.iter().zip(&now.state.xdot).map(|(free, end)| free - end); // h a(x*, ẋ*)
        for (((velocity, before), start_change), end) in
            velocity.iter_mut().zip(&start.xdot).zip(&*start_change).zip(ends)
        {
            *velocity = before + 0.5 * (start_change + end);
        }
        let free = Free { rate: velocity, ..free };
        let touches = work.touches.find(world, now, free.rate, h, memory);
        let contact = work.contacts.solve(world, &free, touches, None, memory)?;
        record.take(contact, 1.0);
        now.set_displaced(world, start, |i| 0.5 * h * (start.xdot[i] + contact.rate[i]), &contact.rate)
    }
}
