//! Detection of the contact points that may touch the ground within a step.

use crate::contact::stops_at_any_height;
use crate::ground::GroundHeights;
use crate::kinematics::Pose;
use crate::model::Model;
use crate::spatial::Spatial;
use messages::scene::{Law, Method, PlantScene};
use nalgebra::Vector3;
use std::ops::Range;

/// A contact point that may touch the ground.
#[derive(Clone, Copy, Debug)]
pub struct Touch {
    /// Index in [`Model::contact_points`].
    pub id: usize,
    /// Link that carries it.
    pub link: usize,
    /// Position from the pose's reference point, as far above its ground as the lowest contact of its link [m]. On level ground all contacts
    /// of a link thus lie in one plane. Otherwise a slightly tilted foot could only stand if it slipped slightly, and the contact problem
    /// would be ill-conditioned. Contacts above one that is deep in the ground keep their heights; see [`flatten`].
    pub arm: Vector3<f64>,
    /// Height above the ground [m].
    pub gap: f64,
    /// Speed at which it may still approach the ground in this step; negative if it must rise [m/s]. See [`allowed_approach`].
    pub approach: f64,
    /// Velocity that it gains from the change of K until the end of the step, in W [m/s]. Zero for methods whose law holds at the pose of
    /// K.
    pub velocity_gain: Vector3<f64>,
    /// Angular velocity that its link gains likewise [rad/s].
    pub angular_gain: Vector3<f64>,
    /// Given direction of its slip in the middle of the step: a unit vector along the ground, or zero if friction is not to act against a
    /// given direction.
    pub slip_direction: Vector3<f64>,
    /// Predicted time until it meets the ground with an impact; infinite if it does not land so [s]. It lands if it approaches faster than the
    /// forces of the step could cause, or if its own motion lifts it again within the step.
    pub lands_after: f64,
}

impl Touch {
    /// A contact point at a position, with an allowed approach of zero.
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

    /// Whether it lands within the step, with an impact.
    pub fn lands(&self) -> bool {
        self.lands_after < f64::INFINITY
    }
}

/// Part of a penetration that one step recovers [-]. A penetration disappears within about ten steps, and the point is never thrown upward.
const RECOVERED_PART: f64 = 0.2;
/// Greatest recovery speed, relative to g h [-]. A recovering point rises by less than its free fall in 50 steps.
const MAX_RECOVERY_SPEED: f64 = 10.0;
/// Greatest penetration that is not recovered, relative to g h² [-]. Methods that only stop velocities leave smaller ones. From twice this
/// depth on, the whole penetration is recovered. In between, the recovered part grows continuously from zero: with a jump,
/// `ImplicitMidpoint` would not converge. It is at most [`level_height`], so that a body does not stay deep in the ground where gravity is strong or the
/// steps are long.
const SHALLOW_PENETRATION: f64 = 5.0;

/// A point is listed if its height is at most this many times the distance that it can fall in a step [-]. The factor leaves room for speed
/// that contact forces add. [`add_penetrating`] adds the points that are faster still.
const SEARCH_FACTOR: f64 = 2.0;

/// A gap or a penetration up to this value is rounding [length of the model]. Corners of one sole whose heights differ by rounding alone
/// must share their load. A gap of 1e-15 m, closed within a step, is a speed that is not small beside the compliance of the contacts.
const HEIGHT_ROUNDING: f64 = 1e-12;

/// See [`level_height`] [length of the model].
const LEVEL: f64 = 1e-3;

/// Whether a height above the ground is rounding.
pub fn is_rounding(gap: f64, model: &Model) -> bool {
    gap.abs() <= HEIGHT_ROUNDING * model.length
}

/// Speed at which a contact may still approach the ground within `h` [m/s]. It may close its gap, less the part that is rounding. So this
/// speed is a continuous function of the gap, and iterations over it converge. It is negative for a deep penetration, which must recover.
pub fn allowed_approach(gap: f64, h: f64, model: &Model) -> f64 {
    let gravity = model.gravity.norm();
    match gap {
        gap if gap > 0.0 => (gap - HEIGHT_ROUNDING * model.length).max(0.0) / h,
        gap => {
            let excess = (gap + shallow_depth(gravity, h, model)).min(0.0);
            recovery_speed(gap.max(2.0 * excess), h, gravity)
        }
    }
}

/// Greatest penetration that is not recovered [m].
fn shallow_depth(gravity: f64, h: f64, model: &Model) -> f64 {
    (SHALLOW_PENETRATION * gravity * h * h).min(level_height(model))
}

/// Speed of approach, negative, at which a point recovers a part of its penetration in a step of `h` [m/s].
pub fn recovery_speed(gap: f64, h: f64, gravity: f64) -> f64 {
    (RECOVERED_PART * gap / h).max(-max_recovery_speed(h, gravity))
}

/// Depth up to which the method of a scene leaves a point of the model inside the ground [m]. See [`SHALLOW_PENETRATION`].
pub fn lasting_depth(plant: &PlantScene, model: &Model) -> f64 {
    let h = match plant.method {
        _ if plant.law == Law::SpringDamper => 0.0,
        Method::MidpointContact | Method::StepDoubling | Method::Rk4Impact | Method::EventDriven => 0.0,
        Method::MidpointMoreau | Method::ImplicitMidpoint => 0.5 * plant.dt, // their contact stages span half a step
        Method::ExplicitEuler | Method::SemiImplicitEuler | Method::MoreauJean | Method::Rk4 => plant.dt,
    };
    shallow_depth(plant.gravity, h, model)
}

/// Greatest speed at which a point leaves the inside of the ground, with steps of `h` [m/s].
pub fn max_recovery_speed(h: f64, gravity: f64) -> f64 {
    MAX_RECOVERY_SPEED * gravity * h
}

/// Lists the points that may touch within a step of `h` [s], link by link and the lowest first. So results do not depend on the order in
/// the scene, nor on left and right. `free` is the velocity at the end of the step without contact.
///
/// The printed laws stop listed points at any height. For them a point is listed if its gap is at most two steps of free fall, 2gh². The
/// other laws let a point close its gap. For them, a point is listed if twice its present speed, or twice its speed without contact, would
/// close the gap. [`add_penetrating`] finds points that contact makes faster still. With `SpringDamper`, only points inside the ground are
/// listed.
pub fn touching(
    model: &Model,
    ground: &GroundHeights,
    pose: &Pose,
    law: Law,
    h: f64,
    free: &[f64],
    touches: &mut Vec<Touch>,
) {
    touches.clear();
    let square_of_reach = |square_of_speed: f64| match law {
        Law::SpringDamper => 0.0,
        law if stops_at_any_height(law) => (SEARCH_FACTOR * h * h).powi(2) * model.gravity.norm_squared(),
        _ => (SEARCH_FACTOR * h).powi(2) * square_of_speed,
    };
    let mut first = 0;
    for points in model.contact_points.chunk_by(|a, b| a.link == b.link) {
        let (link, start, ids) = (points[0].link, touches.len(), first..first + points.len());
        first = ids.end;
        let (now, after) = (pose.links[link].velocity, pose.twist(model, link, free));
        let (com, height) = (pose.links[link].com, lowest_height(model, ground, pose, link, ids.clone()));
        let square_of_bound = |twist: &Spatial| {
            2.0 * (twist.at(&com).norm_squared() + twist.angular.norm_squared() * model.length.powi(2)) // (a + b)² ≤ 2(a² + b²)
        };
        if height > 0.0 && height * height > square_of_reach(square_of_bound(&now).max(square_of_bound(&after))) {
            continue; // the whole link is too high
        }
        for (id, point) in ids.zip(points) {
            let arm = pose.lowest(point);
            let gap = ground.gap_at(pose, &arm, id);
            let square_of_reach = square_of_reach(now.at(&arm).norm_squared().max(after.at(&arm).norm_squared()));
            let in_reach = gap <= 0.0 || gap * gap <= square_of_reach; // no square root: this is done for every point
            if in_reach && point.may_touch(pose.reference.x + arm.x) {
                let approach = allowed_approach(gap, h, model);
                touches.push(Touch { approach, ..Touch::new(id, link, arm, gap) });
            }
        }
        flatten(&mut touches[start..], ground, model);
    }
}

/// A height above the ground that no contact point of a link is below [m]: each is within the model's length of the centre of mass.
fn lowest_height(model: &Model, ground: &GroundHeights, pose: &Pose, link: usize, ids: Range<usize>) -> f64 {
    let highest = ids.map(|id| ground.of(id)).fold(f64::NEG_INFINITY, f64::max);
    pose.reference.z + pose.links[link].com.z - (1.0 + HEIGHT_ROUNDING) * model.length - highest
}

/// Greatest depth of a contact with which the contacts above it are level, and greatest difference of their heights [m]. Points that begin
/// deeper, or are in a tile that they entered from the side, are far from the others: moved to their height, these would have wrong lever arms. A
/// landing that is not located may leave a point half a step's way inside the ground.
pub fn level_height(model: &Model) -> f64 {
    LEVEL * model.length
}

/// Sorts by height above the ground, and moves the contacts of a link to that of the lowest. If that is deeper than [`level_height`], contacts that
/// are higher by more than this are moved to the lowest of themselves instead.
fn flatten(touches: &mut [Touch], ground: &GroundHeights, model: &Model) {
    let level = level_height(model);
    touches.sort_unstable_by(|a, b| a.gap.total_cmp(&b.gap));
    let mut lowest = 0;
    for k in 0..touches.len() {
        let gap = touches[lowest].gap;
        if gap < -level && touches[k].gap - gap > level {
            lowest = k;
        }
        let under = ground.of(touches[lowest].id);
        touches[k].arm.z = touches[lowest].arm.z + (ground.of(touches[k].id) - under);
    }
}

/// Adds points that were not listed and that the velocity `after` the step drives into the ground within `h`. Returns whether there are
/// any.
pub fn add_penetrating(
    model: &Model,
    ground: &GroundHeights,
    pose: &Pose,
    law: Law,
    h: f64,
    after: &[f64],
    touches: &mut Vec<Touch>,
) -> bool {
    if law == Law::SpringDamper || stops_at_any_height(law) {
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
                let gap = ground.gap_at(pose, &arm, id);
                let sinks = gap > 0.0 && gap + h * after.at(&arm).z < 0.0;
                if sinks && point.may_touch(pose.reference.x + arm.x) && !listed(id, touches) {
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
    touches.chunk_by_mut(|a, b| a.link == b.link).for_each(|touches| flatten(touches, ground, model));
    true
}
