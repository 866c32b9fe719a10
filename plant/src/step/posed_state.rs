//! A state together with its pose.

use super::settings::World;
use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::Model;
use crate::state::State;
use messages::rotation::sin_cos;
use messages::scene::Base;
use nalgebra::Vector3;

/// Index of the pitch among the coordinates of the virtual joints.
const PITCH: usize = 4;
/// Cosine of the pitch below which yaw and roll are the same to rounding [-]: the pitch is 90°.
const GIMBAL_COSINE: f64 = 1e-8;

/// Centre of mass of a movable base, if that differs from the origin of its frame; else zero.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct BaseCentre {
    /// From the origin of the base's frame, in W [m].
    pub arm: Vector3<f64>,
    /// Angular velocity of the base [rad/s].
    pub spin: Vector3<f64>,
}

impl BaseCentre {
    /// Motion of the base's centre of mass at a pose, with the rates `xdot`.
    pub fn of(model: &Model, pose: &Pose, xdot: &[f64]) -> BaseCentre {
        if model.base_is_at_its_centre() {
            return BaseCentre::default();
        }
        let spin = pose.twist(model, model.base_link, xdot).angular;
        BaseCentre { arm: pose.links[model.base_link].com, spin }
    }

    /// Velocity relative to the origin of the base's frame.
    pub fn velocity(&self) -> Vector3<f64> {
        self.spin.cross(&self.arm)
    }
}

/// A state and its pose.
#[derive(Clone, Debug)]
pub(super) struct PosedState {
    pub state: State,
    pub pose: Pose,
}

impl PosedState {
    pub fn new(model: &Model, state: State) -> PosedState {
        let mut pose = Pose::new(model);
        kinematics::pose(model, &state, &mut pose);
        PosedState { state, pose }
    }

    /// x₊ = x + time ẋ.
    ///
    /// # Errors
    /// As [`PosedState::update_pose`].
    pub fn integrate_position(&mut self, world: &World, time: f64) -> Result<(), PlantError> {
        self.state.advance(&world.model, time);
        self.update_pose(world)
    }

    /// x₊ = x + time ẋ for the centre of mass of the base instead of its frame. The centre of mass moves on a straight line from where it
    /// was `before`, and the base turns about it. ẋ becomes the velocity of the frame at the end. So no result depends on where the scene
    /// places the frame.
    ///
    /// # Errors
    /// As [`PosedState::update_pose`].
    pub fn integrate_by_com(&mut self, world: &World, time: f64, before: BaseCentre) -> Result<(), PlantError> {
        self.integrate_position(world, time)?;
        let model = &world.model;
        if model.base_is_at_its_centre() {
            return Ok(());
        }
        let after = BaseCentre::of(model, &self.pose, &self.state.xdot);
        let gain = before.velocity() - after.velocity();
        let shift = before.velocity() * time + before.arm - after.arm;
        for (i, &axis) in model.base_translation().iter().enumerate() {
            self.state.x[i] += shift[axis];
            self.state.xdot[i] += gain[axis];
        }
        self.update_pose(world)
    }

    /// Sets x = x0 ⊕ d, and ẋ.
    ///
    /// # Errors
    /// As [`PosedState::update_pose`].
    pub fn set_displaced(
        &mut self,
        world: &World,
        start: &State,
        way: impl Fn(usize) -> f64,
        xdot: &[f64],
    ) -> Result<(), PlantError> {
        self.state.x.copy_from_slice(&start.x);
        self.state.xdot.copy_from_slice(xdot);
        self.state.displace(&world.model, way);
        self.update_pose(world)
    }

    /// Computes the pose of the state.
    ///
    /// # Errors
    /// If the state is not finite, or the virtual joints are singular.
    pub fn update_pose(&mut self, world: &World) -> Result<(), PlantError> {
        let PosedState { state, pose } = self;
        let time = (world.input.steps + 1) as f64 * world.settings.h;
        if !state.x.iter().chain(&state.xdot).all(|number| number.is_finite()) {
            return Err(PlantError::NotFinite { time });
        }
        if world.model.base == Base::Virtual && sin_cos(state.x[PITCH]).1.abs() < GIMBAL_COSINE {
            return Err(PlantError::Gimbal { time });
        }
        kinematics::pose(&world.model, state, pose);
        Ok(())
    }
}
