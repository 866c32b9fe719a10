//! Which contact points can touch the ground within a step.

use crate::kinematics::Pose;
use crate::model::Model;
use messages::scene::Law;
use nalgebra::Vector3;

/// A contact point near enough to the ground to touch it.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Which of [`Model::corners`].
    pub id: usize,
    /// Link that carries it.
    pub link: usize,
    /// Position from the pose's reference point [m].
    pub arm: Vector3<f64>,
    /// Height above the ground [m].
    pub gap: f64,
}

/// Speed that a point may gain within one step and still not be overlooked [m/s].
const SURPRISE: f64 = 0.5;

/// Lists the points that may touch within a step of `h` [s]: link by link, the lowest first, so that results do not depend
/// on the order in which a scene lists them (nor on left and right).
///
/// The printed laws stop whatever touches at any height, so for them touching means a gap no larger than two steps of
/// free fall open, 2gh². The other laws let a point close its gap first, so every point that could is listed. A spring
/// pushes what it is compressed by now.
pub fn touching(model: &Model, pose: &Pose, law: Law, h: f64, touches: &mut Vec<Touch>) {
    touches.clear();
    for (id, corner) in model.corners.iter().enumerate() {
        let arm = pose.lowest(corner);
        let gap = pose.reference.z + arm.z;
        let reach = match law {
            Law::SpringDamper => 0.0,
            Law::EnergyQp | Law::Complementarity => 2.0 * model.gravity.norm() * h * h,
            _ => h * (SURPRISE + 2.0 * pose.links[corner.link].velocity.at(&arm).norm()),
        };
        if gap <= reach && corner.has_ground(pose.reference.x + arm.x) {
            touches.push(Touch { id, link: corner.link, arm, gap });
        }
    }
    for touches in touches.chunk_by_mut(|a, b| a.link == b.link) {
        touches.sort_unstable_by(|a, b| a.gap.total_cmp(&b.gap));
    }
}
