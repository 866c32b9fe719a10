//! A state together with its pose.

use super::settings::World;
use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::Model;
use crate::state::State;
use messages::rotation::sin_cos;
use messages::scene::Base;

/// Index of the pitch among the coordinates of the virtual joints.
pub(super) const PITCH: usize = 4;
/// Cosine of the pitch below which yaw and roll are the same to rounding [-]: the pitch is 90°.
const GIMBAL_COSINE: f64 = 1e-8;

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
