//! Stages of a step before contact: H, b, and the motion without contact.

use super::posed_state::PosedState;
use super::settings::World;
use crate::composite::Composite;
use crate::delassus::Free;
use crate::error::PlantError;
use crate::factor::{Factor, PathMatrix};
use crate::kinematics::{Pose, contact_column};
use crate::model::Model;
use crate::springs;

/// H and b of (1), with springs and dampers of the joints, and H = LᵀDL.
pub(super) struct Dynamics {
    pub composite: Composite,
    pub inertia: PathMatrix,
    pub bias: Vec<f64>,
    pub factor: Factor,
    /// Weight of the velocity at the end of a step in the mean velocity of each joint with a spring or damper, for
    /// [`Dynamics::find_at_midpoint`].
    pub end_weights: Vec<f64>,
    /// Already computed for the next step.
    prepared: bool,
    /// Number of evaluations so far.
    pub evaluations: u64,
}

impl Dynamics {
    pub fn new(model: &Model) -> Dynamics {
        Dynamics {
            composite: Composite::new(model),
            inertia: PathMatrix::new(model),
            bias: vec![0.0; model.dofs()],
            factor: Factor::new(model),
            end_weights: vec![0.5; model.springs.len()],
            prepared: false,
            evaluations: 0,
        }
    }

    /// Computes H, b and the factor of H at the present pose and velocity. The forces of springs and dampers are those after `time`, and
    /// they change implicitly with the velocity over that time; see [`springs`].
    ///
    /// # Errors
    /// If H is not positive definite.
    pub fn find(&mut self, model: &Model, now: &PosedState, time: f64) -> Result<&Dynamics, PlantError> {
        if !std::mem::take(&mut self.prepared) {
            self.evaluations += 1;
            self.composite.inertia(model, &now.pose, &mut self.inertia);
            self.composite.bias(model, &now.pose, &now.state.xdot, &mut self.bias);
            springs::add_to_inertia(model, time, &mut self.inertia);
            springs::add_to_bias(model, &now.state, time, &mut self.bias);
            self.factor.factorize(model, &self.inertia)?;
        }
        Ok(self)
    }

    /// Computes H and its factor for an impact, and sets the impulse of the joint dampers. `times` are those of
    /// [`springs::add_to_impact_inertia`].
    ///
    /// # Errors
    /// If H is not positive definite.
    fn find_at_impact(
        &mut self,
        model: &Model,
        now: &PosedState,
        times: [f64; 2],
        impulse: &mut [f64],
    ) -> Result<&Dynamics, PlantError> {
        self.prepared = false; // the velocity changes
        self.evaluations += 1;
        self.composite.inertia(model, &now.pose, &mut self.inertia);
        springs::add_to_impact_inertia(model, times, &now.state.xdot, &mut self.inertia, impulse);
        self.factor.factorize(model, &self.inertia)?;
        Ok(self)
    }

    /// Sets the couplings of the springs and dampers at a pose.
    ///
    /// # Errors
    /// If H is not positive definite.
    pub fn set_couplings(&mut self, model: &mut Model, now: &PosedState) -> Result<(), PlantError> {
        self.find(model, now, 0.0)?;
        springs::set_couplings(model, &self.inertia, &self.factor);
        Ok(())
    }

    /// Computes H and its factor at the middle of a step of `h`, with springs and dampers at the mean velocity, and b at the velocity
    /// `mean`. The pose must have the velocity `mean`, and the state the velocity before the step.
    ///
    /// # Errors
    /// If H is not positive definite.
    pub fn find_at_midpoint(
        &mut self,
        model: &Model,
        now: &PosedState,
        mean: &[f64],
        h: f64,
    ) -> Result<(), PlantError> {
        self.evaluations += 1;
        self.composite.inertia(model, &now.pose, &mut self.inertia);
        springs::add_to_midpoint_inertia(model, h, &mut self.inertia, &mut self.end_weights);
        self.factor.factorize(model, &self.inertia)?;
        self.with_bias_at(model, now, mean);
        Ok(())
    }

    /// The same at a guess of the middle, which was reached with the velocity `mean`. H includes how springs and dampers change with the step,
    /// so that the next guess has the right forces, however stiff they are.
    ///
    /// # Errors
    /// If H is not positive definite.
    pub fn find_with_guess(
        &mut self,
        model: &Model,
        now: &PosedState,
        mean: &[f64],
        h: f64,
    ) -> Result<&Dynamics, PlantError> {
        self.find_at_midpoint(model, now, mean, h)?;
        for spring in &model.springs {
            self.bias[spring.dof] -= 0.5 * h * spring.stiffness * (mean[spring.dof] - now.state.xdot[spring.dof]);
        }
        Ok(self)
    }

    /// Whether H and b were computed in advance. The mark is cleared for the next step.
    pub fn take_prepared(&mut self) -> bool {
        std::mem::take(&mut self.prepared)
    }

    /// Marks H and b as computed in advance, or not.
    pub fn set_prepared(&mut self, ready: bool) {
        self.prepared = ready;
    }

    /// Computes H and b in advance of the step.
    pub fn prepare(&mut self, model: &Model, now: &PosedState, time: f64) {
        self.prepared = self.find(model, now, time).is_ok(); // the step reports the error again
    }

    /// Recomputes b at the velocity `mean`, with the same H. The pose must have the velocity `mean`, and the state the velocity before the
    /// step.
    pub fn with_bias_at(&mut self, model: &Model, now: &PosedState, mean: &[f64]) -> &Dynamics {
        let Dynamics { composite, bias, .. } = self;
        composite.bias(model, &now.pose, mean, bias);
        springs::add_to_bias(model, &now.state, 0.0, bias);
        for spring in &model.springs {
            bias[spring.dof] -= spring.damping * (mean[spring.dof] - now.state.xdot[spring.dof]); // H already includes that change
        }
        self
    }
}

/// Workspace for the motion without contact.
pub(super) struct FreeMotion {
    efforts: Vec<f64>,
    /// Column of K for a push.
    column: Vec<f64>,
    velocity: Vec<f64>,
    acceleration: Vec<f64>,
}

impl FreeMotion {
    pub fn new(model: &Model) -> FreeMotion {
        let zeros = || vec![0.0; model.dofs()];
        FreeMotion { efforts: zeros(), column: zeros(), velocity: zeros(), acceleration: zeros() }
    }

    /// The motion at the end of a step of `h` without contact. (12)
    pub fn motion<'a>(&'a mut self, world: &World, now: &'a PosedState, dynamics: &'a Dynamics, h: f64) -> Free<'a> {
        let rate = self.velocity(world, now, dynamics, h);
        Free { pose: &now.pose, factor: &dynamics.factor, rate }
    }

    /// The velocity at the end of a step of `h` without contact, ẋ₋ + H⁻¹Δf_b with Δf_b = (u − b)h. (12)
    pub fn velocity(&mut self, world: &World, now: &PosedState, dynamics: &Dynamics, h: f64) -> &[f64] {
        let FreeMotion { efforts, column, velocity, .. } = self;
        let efforts = sum_efforts(world, &now.pose, &dynamics.bias, column, efforts);
        velocity.iter_mut().zip(efforts).for_each(|(free, effort)| *free = effort * h); // Δf_b
        dynamics.factor.solve(&world.model, velocity);
        velocity.iter_mut().zip(&now.state.xdot).for_each(|(free, before)| *free += before);
        velocity
    }

    /// The velocity after an impact without contact: ẋ₋ and what the impulse of the joint dampers changes. `times` are those of
    /// [`springs::add_to_impact_inertia`].
    ///
    /// # Errors
    /// If H is not positive definite.
    pub fn impact<'a>(
        &'a mut self,
        model: &Model,
        now: &'a PosedState,
        dynamics: &'a mut Dynamics,
        times: [f64; 2],
    ) -> Result<Free<'a>, PlantError> {
        let velocity = &mut self.velocity;
        let dynamics = dynamics.find_at_impact(model, now, times, velocity)?;
        dynamics.factor.solve(model, velocity);
        velocity.iter_mut().zip(&now.state.xdot).for_each(|(free, before)| *free += before);
        Ok(Free { pose: &now.pose, factor: &dynamics.factor, rate: velocity })
    }

    /// The last result.
    pub fn found<'a>(&'a self, now: &'a PosedState, dynamics: &'a Dynamics) -> Free<'a> {
        Free { pose: &now.pose, factor: &dynamics.factor, rate: &self.velocity }
    }

    /// The present acceleration without contact, H⁻¹(u − b).
    pub fn acceleration<'a>(&'a mut self, world: &World, now: &'a PosedState, dynamics: &'a Dynamics) -> Free<'a> {
        let FreeMotion { efforts, column, acceleration, .. } = self;
        acceleration.copy_from_slice(sum_efforts(world, &now.pose, &dynamics.bias, column, efforts));
        dynamics.factor.solve(&world.model, acceleration);
        Free { pose: &now.pose, factor: &dynamics.factor, rate: acceleration }
    }
}

/// u − b with the pushes: all efforts except those of contact.
fn sum_efforts<'a>(world: &World, pose: &Pose, bias: &[f64], column: &mut [f64], efforts: &'a mut [f64]) -> &'a [f64] {
    efforts.iter_mut().zip(bias).for_each(|(effort, bias)| *effort = -bias);
    for (&dof, torque) in world.model.joint_dof.iter().zip(world.input.torques.torque) {
        efforts[dof] += torque;
    }
    for push in world.input.pushes.iter().filter(|push| push.steps.contains(&world.input.steps)) {
        let arm = pose.links[push.link].com;
        contact_column(&world.model, pose, push.link, &arm, &push.force, column);
        for (k, &dof) in column.iter().zip(world.model.path(push.link)) {
            efforts[dof] += k;
        }
    }
    efforts
}
