//! Rotation that a step can resolve.

use super::Plant;
use super::posed_state::{PITCH, PosedState};
use super::settings::World;
use crate::error::PlantError;
use messages::rotation::sin_cos;
use messages::scene::Base;
use std::f64::consts::PI;

/// Greatest turn of a virtual joint in a step near their pole [rad]. A pass turns yaw and roll by half a turn together, so it takes three steps
/// at this rate. In fewer steps it makes energy without limit.
const TURN_NEAR_POLE: f64 = 1.0;
/// The pole is near if the base would reach it in this many steps [-]. From there on the joints turn by half a radian in a step.
const STEPS_TO_POLE: f64 = 2.0;
/// At this distance and beyond, the pole is not near, however fast the base turns [rad].
const FAR_FROM_POLE: f64 = 0.2;

impl Plant {
    /// Whether the base could turn to the pole of its virtual joints within about a step.
    pub(super) fn is_near_pole(&self) -> bool {
        let (World { model, settings, .. }, PosedState { state, pose }) = (&self.world, &self.state.now);
        if model.base != Base::Virtual {
            return false;
        }
        let turn = pose.links[model.base_link].velocity.angular.norm() * settings.h;
        sin_cos(state.x[PITCH]).1.abs() <= (STEPS_TO_POLE * turn).min(FAR_FROM_POLE)
    }

    /// Checks that nothing turns by more than half a turn per step, nor a virtual joint near the pole by more than [`TURN_NEAR_POLE`].
    /// Faster rotation is aliased, so its result is meaningless and may have any energy. Methods that choose their own steps are exempt.
    pub(super) fn check_rotation_rate(&self, near_pole: bool) -> Result<(), PlantError> {
        let (World { model, settings, .. }, state) = (&self.world, &self.state.now.state);
        let (rate, dt, time) = (state.fastest_turn(model), settings.h, self.world.time());
        if settings.method.chooses_steps() {
            return Ok(());
        }
        if near_pole && state.xdot[3..6].iter().any(|rate| rate.abs() * dt > TURN_NEAR_POLE) {
            return Err(PlantError::Gimbal { time });
        }
        if rate * dt > PI { Err(PlantError::Spins { time, rate, dt }) } else { Ok(()) }
    }
}
