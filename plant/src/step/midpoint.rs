//! Midpoint methods: all forces at the middle of the step, second order.

use super::Plant;
use super::settings::World;
use super::step_state::StepState;
use super::workspace::Workspace;
use crate::error::PlantError;
use crate::kinematics;
use crate::springs;

/// Iterations of the implicit rule at most; three or four are typical for a useful dt.
const MAX_ITERATIONS: usize = 60;
/// A change of the mean velocity this small, relative to 1 + |ẋ|, is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// A change this small in the last iteration is accepted.
const ACCEPTED_CHANGE: f64 = 1e-9;

impl Plant {
    /// x_m = x + ½h ẋ₋; ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf) with H, b, K and gaps at x_m; x₊ = x_m + ½h ẋ₊.
    ///
    /// b is quadratic in the velocity, so it is evaluated at the mean velocity of the motion without contact. Two evaluations of b and one
    /// of H make the flight second order. A lasting contact that rolls is first order: the law holds for Kᵀẋ₊ at the middle, which opens or
    /// closes the gap by ½h²ω²l per step. Springs and dampers of joints act as in [`springs::add_to_midpoint_inertia`]. In flight with springs
    /// the step is that of [`Plant::implicit_midpoint`]: with x_m from ẋ₋ alone they would change the energy steadily.
    ///
    /// # Source
    /// Moreau (1988); Jean, *The non-smooth contact dynamics method* (1999), with θ = ½; Acary & Brogliato (2008), 10.1.
    pub(super) fn midpoint_moreau(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        work.start.copy(&now.state);
        now.integrate_position(world, 0.5 * h)?;
        work.dynamics.find_at_midpoint(&world.model, now, &now.state.xdot, h)?;
        let mean = work.free.velocity(world, now, &work.dynamics, 0.5 * h);
        kinematics::velocities(&world.model, mean, &mut now.pose);
        let dynamics = work.dynamics.with_bias_at(&world.model, now, mean);
        let free = work.free.motion(world, now, dynamics, h);
        let touches = work.touches.find(world, now, free.rate, 0.5 * h, memory);
        if touches.list.is_empty() && world.model.has_springs() {
            now.state.copy(&work.start);
            return self.implicit_midpoint(h);
        }
        let contact = work.contacts.solve(world, &free, touches, None, memory)?;
        record.take(contact, 1.0);
        if contact.impulses.is_empty() {
            let (rates, x) = ([&now.state.xdot[..], &contact.rate], &mut now.state.x);
            springs::move_by_weighted_mean(&world.model, &dynamics.end_weights, h, rates, x);
        }
        now.state.xdot.copy_from_slice(&contact.rate);
        now.integrate_position(world, 0.5 * h)
    }

    /// ẋ_m = ½(ẋ₋ + ẋ₊), x_m = x + ½h ẋ_m, x₊ = x + h ẋ_m; ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf) with all of H, b, K at (x_m, ẋ_m).
    ///
    /// Symmetric in time: in flight the energy oscillates by h² and does not drift. The contact law holds for ẋ₊, as in
    /// [`Plant::midpoint_moreau`], and so do springs and dampers of joints.
    ///
    /// # Errors
    /// If the iteration does not converge: dt is too long.
    ///
    /// # Source
    /// Hairer, Lubich & Wanner, *Geometric Numerical Integration*, II.1 and VIII.6.
    pub(super) fn implicit_midpoint(&mut self, h: f64) -> Result<(), PlantError> {
        let Plant { world, state: StepState { now, memory, record, .. }, work, .. } = self;
        let Workspace { start, mean, dynamics, free, touches, contacts, .. } = work;
        start.copy(&now.state);
        mean.copy_from_slice(&start.xdot);
        let mut rounds = 0;
        let (contact, change) = loop {
            now.state.x.copy_from_slice(&start.x);
            now.state.xdot.copy_from_slice(mean);
            now.integrate_position(world, 0.5 * h)?; // (x_m, ẋ_m)
            now.state.xdot.copy_from_slice(&start.xdot);
            let dynamics = dynamics.find_with_guess(&world.model, now, mean, h)?;
            let free = free.motion(world, now, dynamics, h);
            let touches = touches.find(world, now, free.rate, 0.5 * h, memory);
            let contact = contacts.solve(world, &free, touches, None, memory)?;
            let change = update_mean(mean, &start.xdot, &contact.rate);
            rounds += 1;
            if change <= ROUNDING || rounds == MAX_ITERATIONS {
                break (contact, change);
            }
        };
        check_convergence(world, change, rounds)?;
        record.take(contact, 1.0);
        if contact.impulses.is_empty() {
            let rates = [&start.xdot[..], &contact.rate];
            springs::move_by_weighted_mean(&world.model, &dynamics.end_weights, h, rates, &mut start.x);
        }
        now.set_displaced(world, start, |i| h * mean[i], &contact.rate)
    }
}

/// Sets the mean to ½(ẋ₋ + ẋ₊); returns its greatest change, relative to 1 + |ẋ|. The change to what is no number is infinite.
pub(super) fn update_mean(mean: &mut [f64], before: &[f64], after: &[f64]) -> f64 {
    let mut change = 0.0;
    for ((mean, after), before) in mean.iter_mut().zip(after).zip(before) {
        let better = 0.5 * (before + after);
        let relative = (better - *mean).abs() / (1.0 + better.abs());
        change = if relative.is_nan() { f64::INFINITY } else { change.max(relative) };
        *mean = better;
    }
    change
}

/// Checks the change of the mean velocity in the last iteration.
///
/// # Errors
/// If it is greater than [`ACCEPTED_CHANGE`].
pub(super) fn check_convergence(world: &World, change: f64, rounds: usize) -> Result<(), PlantError> {
    if change <= ACCEPTED_CHANGE {
        return Ok(());
    }
    let reason = format!("its velocity still changes by {change:.1e} after {rounds} rounds; plant.dt is too long");
    Err(PlantError::NotConverged { time: world.time(), reason })
}
