//! Where the robot is and how it moves: a state, and the pose that belongs to it.

use super::settings::World;
use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::Model;
use crate::state::State;
use messages::rotation::sin_cos;
use messages::scene::Base;
use nalgebra::Vector3;

/// Coordinate of the pitch of virtual joints.
const PITCH: usize = 4;
/// Cosine of a pitch so near to 90° that yaw and roll are the same to rounding.
const GIMBAL: f64 = 1e-8;

/// The centre of mass of a base that can move, where that is not in its frame's origin; else all zero.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Centre {
    /// From the base's frame, in W [m].
    pub arm: Vector3<f64>,
    /// Angular velocity of the base [rad/s].
    pub spin: Vector3<f64>,
}

impl Centre {
    /// At a pose, with these rates.
    pub fn of(model: &Model, pose: &Pose, xdot: &[f64]) -> Centre {
        if model.base_is_at_its_centre() {
            return Centre::default();
        }
        let spin = pose.twist(model, model.base_link, xdot).angular;
        Centre { arm: pose.links[model.base_link].com, spin }
    }

    /// Its velocity beside that of the frame.
    pub fn gained(&self) -> Vector3<f64> {
        self.spin.cross(&self.arm)
    }
}

/// A state and its pose.
pub(super) struct Now {
    pub state: State,
    pub pose: Pose,
}

impl Now {
    pub fn new(model: &Model, state: State) -> Now {
        let mut pose = Pose::new(model);
        kinematics::pose(model, &state, &mut pose);
        Now { state, pose }
    }

    /// x₊ = x + time ẋ.
    ///
    /// # Errors
    /// As [`Now::find_pose`], and so the following.
    pub fn travel(&mut self, world: &World, time: f64) -> Result<(), PlantError> {
        self.state.advance(&world.model, time);
        self.find_pose(world)
    }

    /// x₊ = x + time ẋ with the centre of mass of the base in place of its frame, from where that was `before`: it goes straight, the base
    /// turns about it, and ẋ is what the frame's velocity has become by then. So no result depends on where somebody has put the frame.
    ///
    /// # Errors
    /// As [`Now::find_pose`].
    pub fn travel_by_centre(&mut self, world: &World, time: f64, before: Centre) -> Result<(), PlantError> {
        self.travel(world, time)?;
        let model = &world.model;
        if model.base_is_at_its_centre() {
            return Ok(());
        }
        let after = Centre::of(model, &self.pose, &self.state.xdot);
        let gain = before.gained() - after.gained();
        let shift = before.gained() * time + before.arm - after.arm;
        for (i, &axis) in model.base_translation().iter().enumerate() {
            self.state.x[i] += shift[axis];
            self.state.xdot[i] += gain[axis];
        }
        self.find_pose(world)
    }

    /// x = x0 ⊕ d, and ẋ as given.
    pub fn place(
        &mut self,
        world: &World,
        start: &State,
        way: impl Fn(usize) -> f64,
        xdot: &[f64],
    ) -> Result<(), PlantError> {
        self.state.x.copy_from_slice(&start.x);
        self.state.xdot.copy_from_slice(xdot);
        self.state.displace(&world.model, way);
        self.find_pose(world)
    }

    /// The pose that belongs to the state.
    ///
    /// # Errors
    /// If the state is not finite, or the virtual joints stand at their pole.
    pub fn find_pose(&mut self, world: &World) -> Result<(), PlantError> {
        let Now { state, pose } = self;
        let time = (world.steps + 1) as f64 * world.settings.h;
        if !state.x.iter().chain(&state.xdot).all(|number| number.is_finite()) {
            return Err(PlantError::NotFinite { time });
        }
        if world.model.base == Base::Virtual && sin_cos(state.x[PITCH]).1.abs() < GIMBAL {
            return Err(PlantError::Gimbal { time });
        }
        kinematics::pose(&world.model, state, pose);
        Ok(())
    }
}
