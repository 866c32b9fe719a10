//! Euler's methods: one evaluation per step, first order.

use super::Plant;
use super::step_state::StepState;
use crate::error::PlantError;

impl Plant {
    /// ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf), x₊ = x + h ẋ₊; all forces at x.
    ///
    /// # Source
    /// (12)-(22). Symplectic where H is constant: Hairer, Lubich & Wanner, *Geometric Numerical Integration*, I.1.
    pub(super) fn semi_implicit_euler(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let dynamics = work.dynamics.find(&world.model, now, h)?; // (1)-(11)
        let free = work.free.motion(world, now, dynamics, h); // (12)
        let touches = work.touches.find(world, now, free.rate, h, memory);
        let contact = work.contacts.solve(world, &free, touches, None, memory)?; // (12)-(22)
        record.take(contact, 1.0);
        std::mem::swap(&mut now.state.xdot, &mut work.contacts.contact.rate); // every step sets the rate anew
        now.integrate_position(world, h)
    }

    /// The same with x₊ = x + h ẋ₋. An oscillation grows by the factor √(1 + ω²h²) per step, and a landing is stopped one step late.
    pub(super) fn explicit_euler(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let dynamics = work.dynamics.find(&world.model, now, 0.0)?; // (1)-(11)
        let free = work.free.motion(world, now, dynamics, h); // (12)
        let touches = work.touches.find(world, now, free.rate, h, memory);
        let contact = work.contacts.solve(world, &free, touches, None, memory)?; // (12)-(22)
        record.take(contact, 1.0);
        now.state.advance(&world.model, h);
        now.state.xdot.copy_from_slice(&contact.rate);
        now.update_pose(world)
    }
}
