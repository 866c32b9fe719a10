//! The height of the ground under each contact point.
//!
//! Uneven ground consists of horizontal tiles. A contact point meets the plane at the height of the tile that is under it at the beginning
//! of a step. The vertical walls between tiles are not contacts. So a point may enter a higher tile from the side:
//!
//! - A point that carries load keeps the height that it stands on, until it carries none.
//! - A point without load is inside the higher tile. It leaves it like any point that begins inside the ground, slowly: see
//!   [`crate::detect::recovery_speed`].
//!
//! A point over a lower tile falls, with or without load.

use crate::kinematics::Pose;
use crate::model::Model;
use nalgebra::Vector3;

/// A point farther than this above its ground carries no load [length of the model].
const LIFTED: f64 = 1e-6;
/// The same for the errors of h² with which a step leaves the heights of contacts [g h²]: a sphere that rolls under load rises and sinks by them.
const LIFTED_IN_STEP: f64 = 1.0;

/// Height of the ground that each contact point meets [m].
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct GroundHeights(Vec<f64>);

impl GroundHeights {
    /// The plane z = 0 under every contact point.
    pub fn plane(model: &Model) -> GroundHeights {
        GroundHeights(vec![0.0; model.contact_points.len()])
    }

    /// The tiles under the contact points.
    pub fn under(model: &Model, pose: &Pose) -> GroundHeights {
        let heights = model.contact_points.iter().map(|point| model.ground_at(&(pose.reference + pose.lowest(point))));
        GroundHeights(heights.collect())
    }

    /// Copies other heights without allocation.
    pub fn copy(&mut self, other: &GroundHeights) {
        self.0.copy_from_slice(&other.0);
    }

    /// Height of the ground that contact point `id` meets [m].
    #[inline]
    pub fn of(&self, id: usize) -> f64 {
        self.0[id]
    }

    /// Height of a contact point above the ground that it meets [m].
    #[inline]
    pub fn gap(&self, model: &Model, pose: &Pose, id: usize) -> f64 {
        self.gap_at(pose, &pose.lowest(&model.contact_points[id]), id)
    }

    /// The same, of a contact point whose [`Pose::lowest`] is `arm`.
    #[inline]
    pub fn gap_at(&self, pose: &Pose, arm: &Vector3<f64>, id: usize) -> f64 {
        pose.reference.z + arm.z - self.of(id)
    }

    /// Takes the tile under a contact point before a step of `h` [s]; returns whether its height differs from that of the ground before.
    pub(crate) fn update(&mut self, model: &Model, pose: &Pose, id: usize, had_force: bool, h: f64) -> bool {
        let place = pose.reference + pose.lowest(&model.contact_points[id]);
        let (height, before) = (model.ground_at(&place), self.of(id));
        let lifted = f64::max(LIFTED * model.length, LIFTED_IN_STEP * model.gravity.norm() * h * h);
        let stands = had_force && place.z - before <= lifted;
        let changes = height != before && !(height > before && stands);
        if changes {
            self.0[id] = height;
        }
        changes
    }
}
