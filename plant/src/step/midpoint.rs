//! Midpoint methods: all forces at the middle of the step, second order.

use super::{Plant, Workspace};
use crate::error::PlantError;
use crate::{kinematics, springs};

/// Rounds of the implicit rule at most; it takes three or four where dt is short enough to be of use.
const ROUNDS: usize = 60;
/// A change of the mean velocity this small, relative to 1 + |ẋ|, is rounding.
const ROUNDING: f64 = 4.0 * f64::EPSILON;
/// A change this small at the last round is good enough to go on with.
const ENOUGH: f64 = 1e-9;

impl Plant {
    /// x_m = x + ½h ẋ₋; ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf) with H, b, K and gaps at x_m; x₊ = x_m + ½h ẋ₊.
    ///
    /// b is quadratic in the velocity, so it is taken at the mean velocity that it would lead to itself without contact:
    /// two evaluations of b and one of H make the flight of second order. A lasting contact that pivots is of first order:
    /// the law asks for Kᵀẋ₊ at the middle, which opens the gap by ½h²ω²l a step or closes it.
    ///
    /// # Source
    /// Moreau (1988); Jean, *The non-smooth contact dynamics method* (1999), with θ = ½; Acary & Brogliato (2008), 10.1.
    pub(super) fn midpoint_moreau(&mut self, h: f64) -> Result<(), PlantError> {
        self.travel(0.5 * h)?;
        self.find_inertia(0.5 * h, 0.0)?;
        self.predict_free_motion(0.5 * h);
        let Workspace { pose, composite, free, mean, .. } = &mut self.work;
        mean.copy_from_slice(free);
        kinematics::velocities(&self.model, mean, pose);
        composite.bias(&self.model, pose, mean, free);
        springs::pull(&self.model, &self.state, 0.0, free);
        for spring in &self.model.springs {
            free[spring.dof] -= spring.damping * (mean[spring.dof] - self.state.xdot[spring.dof]); // H has it already
        }
        self.predict_free_motion(h);
        self.find_touches(0.5 * h);
        self.solve_contacts(0.5 * h)?;
        self.record_contacts();
        self.travel(0.5 * h)
    }

    /// ẋ_m = ½(ẋ₋ + ẋ₊), x_m = x + ½h ẋ_m, x₊ = x + h ẋ_m; ẋ₊ = ẋ₋ + H⁻¹(Δf_b + KΔf) with all of H, b, K at (x_m, ẋ_m).
    ///
    /// Symmetric in time: in flight the energy swings by h² and does not drift. The contact law holds for ẋ₊, as in
    /// [`Plant::midpoint_moreau`].
    ///
    /// # Errors
    /// If the iteration does not settle: dt is too long.
    ///
    /// # Source
    /// Hairer, Lubich & Wanner, *Geometric Numerical Integration*, II.1 and VIII.6.
    pub(super) fn implicit_midpoint(&mut self, h: f64) -> Result<(), PlantError> {
        self.begin();
        self.work.mean.copy_from_slice(&self.state.xdot);
        let mut change = f64::INFINITY;
        for _ in 0..ROUNDS {
            let Workspace { stages, mean, .. } = &self.work;
            self.state.copy(&stages.start);
            self.state.xdot.copy_from_slice(mean);
            self.travel(0.5 * h)?;
            self.find_inertia(0.0, 0.0)?;
            self.state.xdot.copy_from_slice(&self.work.stages.start.xdot);
            self.predict_free_motion(h);
            self.find_touches(0.5 * h);
            self.solve_contacts(0.5 * h)?;
            let Workspace { stages, mean, .. } = &mut self.work;
            change = 0.0;
            for ((mean, after), before) in mean.iter_mut().zip(&self.state.xdot).zip(&stages.start.xdot) {
                let better = 0.5 * (before + after);
                change = f64::max(change, (better - *mean).abs() / (1.0 + better.abs()));
                *mean = better;
            }
            if change <= ROUNDING {
                break;
            }
        }
        if change > ENOUGH {
            let reason =
                format!("its velocity still changes by {change:.1e} after {ROUNDS} rounds; plant.dt is too long");
            return Err(PlantError::Unsettled { time: self.steps as f64 * self.settings.h, reason });
        }
        self.record_contacts();
        let Workspace { stages, mean, change, .. } = &mut self.work;
        change.iter_mut().zip(mean.iter()).for_each(|(d, v)| *d = h * v);
        self.state.displace(&self.model, &stages.start, change);
        self.pose()
    }
}
