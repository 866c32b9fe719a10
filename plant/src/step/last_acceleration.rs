//! The acceleration of the step before.

use super::posed_state::BaseCentre;
use crate::model::Model;
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// Acceleration of the step before, including contact.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub(super) struct LastAcceleration {
    rate: Vec<f64>,
    /// Angular acceleration of the base [rad/s²], and its centre of mass relative to its frame [m].
    #[serde(with = "crate::serial::vector")]
    turn: Vector3<f64>,
    #[serde(with = "crate::serial::vector")]
    arm: Vector3<f64>,
    /// False at the start and after an impact.
    pub known: bool,
}

impl LastAcceleration {
    pub fn new(model: &Model) -> LastAcceleration {
        LastAcceleration { rate: vec![0.0; model.dofs()], turn: Vector3::zeros(), arm: Vector3::zeros(), known: false }
    }

    /// Copies another acceleration without allocation.
    pub fn copy(&mut self, other: &LastAcceleration) {
        self.rate.copy_from_slice(&other.rate);
        (self.turn, self.arm, self.known) = (other.turn, other.arm, other.known);
    }

    /// Marks the acceleration as unknown.
    pub fn forget(&mut self) {
        self.known = false;
    }

    /// Sets the acceleration from a step of `h`: the velocities and the centre of mass of the base before and after.
    pub fn set(&mut self, before: &[f64], after: &[f64], [start, end]: [BaseCentre; 2], h: f64) {
        let pairs = before.iter().zip(after);
        self.rate.iter_mut().zip(pairs).for_each(|(rate, (before, after))| *rate = (after - before) / h);
        (self.turn, self.arm, self.known) = ((end.spin - start.spin) / h, start.arm, true);
    }

    /// Adds the velocity that the acceleration causes within a time. `arm` points from the base's frame to its centre of mass.
    pub fn add(&self, model: &Model, arm: &Vector3<f64>, time: f64, velocity: &mut [f64]) {
        velocity.iter_mut().zip(&self.rate).for_each(|(v, rate)| *v += time * rate);
        let moved = self.turn.cross(&(self.arm - arm)) * time;
        velocity.iter_mut().zip(model.base_translation()).for_each(|(v, &axis)| *v += moved[axis]);
    }
}
