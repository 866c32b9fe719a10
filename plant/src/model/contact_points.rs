//! The points and balls of a scene that may touch the ground.

use super::check::{finite, not_negative};
use super::{ContactPoint, Model};
use crate::error::PlantError;
use crate::kinematics::Pose;
use crate::state::State;
use messages::robot::Body;

/// A point whose velocity is this small while a joint moves with 1 rad/s or 1 m/s lies on the axis of the joint [length of the model].
const ON_AXIS: f64 = 1e-12;

pub(super) fn contact_points(bodies: &[Body], body_link: &[usize]) -> Result<Vec<ContactPoint>, PlantError> {
    let mut contact_points = vec![];
    for (body, &link) in bodies.iter().zip(body_link) {
        for ball in body.contact_spheres() {
            let at = finite(ball.at, || format!("a contact point of body `{}`", body.name))?;
            let radius = not_negative(ball.radius, "the radius of a ball")?;
            contact_points.push(ContactPoint { link, at, radius, tiles: body.tiles, moves: true });
        }
    }
    Ok(contact_points)
}

impl Model {
    /// Sets [`ContactPoint::moves`]. A point that no joint moves lies on the axes of all joints of its path, so it stays where it is, and one
    /// pose shows it. Only a fixed base has such points.
    pub(super) fn find_unmoved_points(&mut self) {
        let pose = Pose::of(self, &State::zero(self));
        let moves = |point: &ContactPoint| {
            let arm = pose.arm(point.link, &point.at);
            let speed = |&dof: &usize| pose.links[dof + 1].column.at(&arm).norm();
            self.path(point.link).iter().map(speed).any(|speed| speed > ON_AXIS * self.length)
        };
        let moves: Vec<bool> = self.contact_points.iter().map(moves).collect();
        self.contact_points.iter_mut().zip(moves).for_each(|(point, moves)| point.moves = moves);
    }
}
