//! Euler's methods: one evaluation a step, first order.

use super::Plant;
use crate::error::PlantError;

impl Plant {
    /// ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf), x₊ = x + h ẋ₊; all forces at x.
    ///
    /// # Source
    /// (12)-(22). Symplectic where H is constant: Hairer, Lubich & Wanner, *Geometric Numerical Integration*, I.1.
    pub(super) fn semi_implicit_euler(&mut self, h: f64) -> Result<(), PlantError> {
        if !std::mem::take(&mut self.ready) {
            self.find_inertia(h, h)?;
        }
        self.predict_free_motion(h);
        self.find_touches(h);
        self.solve_contacts(h)?;
        self.record_contacts();
        self.travel(h)
    }

    /// The same with x₊ = x + h ẋ₋. An oscillation grows by the factor √(1 + ω²h²) a step, and what lands is stopped one step
    /// late.
    pub(super) fn explicit_euler(&mut self, h: f64) -> Result<(), PlantError> {
        self.find_inertia(0.0, 0.0)?;
        self.predict_free_motion(h);
        self.find_touches(h);
        self.state.advance(&self.model, h); // the contact impulses keep to the pose before
        self.solve_contacts(h)?;
        self.record_contacts();
        self.pose()
    }
}
