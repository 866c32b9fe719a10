//! Which contact points can touch the ground within a step.

use crate::kinematics::Pose;
use crate::model::Model;
use messages::scene::Law;
use nalgebra::Vector3;

/// A contact point near enough to the ground to touch it.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Which of [`Model::points`].
    pub id: usize,
    /// Link that carries it.
    pub link: usize,
    /// Where it touches, from the pose's reference point [m]: it, at the height of the lowest contact of its link. These are thus in one
    /// plane: a foot that lands askew by a hair would else have to slip by a hair to stand, and contact be as ill-posed as that is little.
    pub arm: Vector3<f64>,
    /// Height above the ground [m].
    pub gap: f64,
    /// Speed at which it may still come down in this step; negative: it must go up [m/s]. See [`approach`].
    pub approach: f64,
    /// Velocity that K gains on the way to the end of the step, in W [m/s]. Zero for a method whose law holds where K is taken.
    pub velocity_gain: Vector3<f64>,
    /// Angular velocity that its link gains there likewise [rad/s].
    pub angular_gain: Vector3<f64>,
    /// Direction of its slip in the middle of the step, if friction is to act against that: a unit vector along the ground, else zero.
    pub slip_direction: Vector3<f64>,
    /// Time after which it meets the ground, as its motion to the middle of the step says, if it comes down faster than the step's forces make
    /// it; else infinite [s].
    pub lands_after: f64,
}

impl Touch {
    /// A contact point at a place, which may not come down any further.
    pub fn new(id: usize, link: usize, arm: Vector3<f64>, gap: f64) -> Touch {
        let none = Vector3::zeros();
        Touch {
            id,
            link,
            arm,
            gap,
            approach: 0.0,
            velocity_gain: none,
            angular_gain: none,
            slip_direction: none,
            lands_after: f64::INFINITY,
        }
    }

    /// Whether it comes down faster than the step's forces make it.
    pub fn lands(&self) -> bool {
        self.lands_after < f64::INFINITY
    }
}

/// Part of a depth that one step takes back [-]: what a step's error leaves is gone within some ten steps, and never thrown back.
const RECOVERED_PART: f64 = 0.2;
/// Greatest speed at which a depth is taken back, as a part of g h [-]: what comes out rises by less than 50 steps of its own fall.
const MAX_RECOVERY_SPEED: f64 = 10.0;
/// A depth that is more than a step's error, as a part of g h² [-]: what methods that stop velocities alone let stay inside the ground.
const DEEP_PENETRATION: f64 = 10.0;

/// A contact point is listed if it is no higher than this many times the way that it can fall in a step [-]. The factor leaves room for what
/// contact forces add to its speed; [`add_penetrating`] adds the points that are faster still.
const SEARCH_FACTOR: f64 = 2.0;

/// Speed at which a contact may still come down within `h` [m/s]: it closes its gap. Deep inside the ground it is negative: it comes out.
pub fn allowed_approach(gap: f64, h: f64, gravity: f64) -> f64 {
    match gap {
        gap if gap > 0.0 => gap / h,
        gap if gap < -DEEP_PENETRATION * gravity * h * h => recovery_speed(gap, h, gravity),
        _ => 0.0,
    }
}

/// Speed at which a contact may come down that is to come out of the ground by a part of its depth in a step of `h` [m/s].
pub fn recovery_speed(gap: f64, h: f64, gravity: f64) -> f64 {
    (RECOVERED_PART * gap / h).max(-MAX_RECOVERY_SPEED * gravity * h)
}

/// Lists the points that may touch within a step of `h` [s], link by link, the lowest first, so that results do not depend on the order in
/// which a scene lists them (nor on left and right). `free` is the velocity that the step would end with if nothing touched.
///
/// The printed laws stop whatever touches at any height, so for them touching means a gap no larger than two steps of
/// free fall open, 2gh². The other laws let a point close its gap first, so every point is listed that could close it, by its
/// velocity now or without contact, going twice as far; what contact makes faster still is seen afterwards: [`add_penetrating`]. A spring
/// pushes what it is compressed by now.
pub fn touching(model: &Model, pose: &Pose, law: Law, h: f64, free: &[f64], touches: &mut Vec<Touch>) {
    touches.clear();
    let mut first = 0;
    for points in model.contact_points.chunk_by(|a, b| a.link == b.link) {
        let (link, start) = (points[0].link, touches.len());
        let (now, after) = (pose.links[link].velocity, pose.twist(model, link, free));
        for (id, point) in (first..).zip(points) {
            let arm = pose.lowest(point);
            let gap = pose.reference.z + arm.z;
            let reach = match law {
                Law::SpringDamper => 0.0,
                Law::EnergyQp | Law::Complementarity => SEARCH_FACTOR * model.gravity.norm() * h * h,
                _ => SEARCH_FACTOR * h * now.at(&arm).norm_squared().max(after.at(&arm).norm_squared()).sqrt(),
            };
            if gap <= reach && point.has_ground(pose.reference.x + arm.x) {
                let approach = allowed_approach(gap, h, model.gravity.norm());
                touches.push(Touch { approach, ..Touch::new(id, link, arm, gap) });
            }
        }
        first += points.len();
        flatten(&mut touches[start..]);
    }
}

/// Lists the lowest first, and gives all contacts of a link its height.
fn flatten(touches: &mut [Touch]) {
    touches.sort_unstable_by(|a, b| a.gap.total_cmp(&b.gap));
    let height = touches.first().map_or(0.0, |lowest| lowest.arm.z);
    touches.iter_mut().for_each(|touch| touch.arm.z = height);
}

/// Adds the points that were not listed and that the velocity `after` the step takes into the ground within `h`; whether there are any.
pub fn add_penetrating(model: &Model, pose: &Pose, law: Law, h: f64, after: &[f64], touches: &mut Vec<Touch>) -> bool {
    if matches!(law, Law::SpringDamper | Law::EnergyQp | Law::Complementarity) {
        return false;
    }
    let (before, mut first) = (touches.len(), 0);
    for points in model.contact_points.chunk_by(|a, b| a.link == b.link) {
        let link = points[0].link;
        let listed = |id: usize, touches: &[Touch]| touches[..before].iter().any(|touch| touch.id == id);
        if touches[..before].iter().filter(|touch| touch.link == link).count() < points.len() {
            let after = pose.twist(model, link, after);
            for (id, point) in (first..).zip(points) {
                let arm = pose.lowest(point);
                let gap = pose.reference.z + arm.z;
                let sinks = gap > 0.0 && gap + h * after.at(&arm).z < 0.0;
                if sinks && point.has_ground(pose.reference.x + arm.x) && !listed(id, touches) {
                    touches.push(Touch { approach: gap / h, ..Touch::new(id, link, arm, gap) });
                }
            }
        }
        first += points.len();
    }
    if touches.len() == before {
        return false;
    }
    touches.sort_by_key(|touch| touch.link);
    touches.chunk_by_mut(|a, b| a.link == b.link).for_each(flatten);
    true
}
