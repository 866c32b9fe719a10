//! Quantities derived from one [`Truth`] record: centre of mass, soles, loads, zero-moment point.

use super::foot_geometry::FootGeometry;
use super::kinematic_tree::{BodyState, KinematicTree};
use messages::wire::{CONTACTS, Truth};
use nalgebra::{Point3, Vector2, Vector3};

/// Quantities derived from one record, in the world frame W.
#[derive(Clone, Debug)]
pub struct DerivedState {
    /// Simulated time [s].
    pub time: f64,
    /// Centre of mass [m].
    pub com: Vector3<f64>,
    /// Velocity [m/s].
    pub com_velocity: Vector3<f64>,
    /// Soles of the left and right foot.
    pub soles: Option<[SoleState; 2]>,
    /// Zero-moment point on the ground, x and y [m]. NaN without contact force.
    pub zmp: Vector2<f64>,
    /// Sum of the normal forces on all contact points [N].
    pub load: f64,
    /// Least height of a contact point above the ground under it [m]. Infinite if the robot has none, or is over gaps of the ground.
    pub clearance: f64,
    /// Height of the lowest contact point in W [m]. Infinite if the robot has none.
    pub lowest_point: f64,
    /// Height of the trunk's centre of mass [m].
    pub trunk_height: f64,
    /// Angle between the z axes of the trunk and the world [rad].
    pub trunk_tilt: f64,
}

/// The sole of one foot.
#[derive(Clone, Copy, Debug)]
pub struct SoleState {
    /// Centre [m].
    pub centre: Vector3<f64>,
    /// Heading of the foot: a horizontal unit vector.
    pub heading: Vector2<f64>,
    /// Angle between the sole and the ground [rad].
    pub tilt: f64,
    /// Normal force on its contact points [N].
    pub load: f64,
    /// Least height of a contact point above the ground under it [m]. Infinite if the foot has none.
    pub clearance: f64,
    /// Distance of the zero-moment point from the edge of the sole; negative outside [m].
    pub zmp_margin: f64,
}

impl DerivedState {
    /// Derives the quantities from a record. `states` is the result of [`KinematicTree::body_states`] for that record.
    pub fn new(robot: &KinematicTree, truth: &Truth, states: &[BodyState]) -> Self {
        let (com, com_velocity) = robot.com(states);
        let (mut load, mut moment) = (0.0, Vector2::zeros());
        let (mut clearance, mut lowest_point) = (f64::INFINITY, f64::INFINITY);
        let mut on_feet = [(0.0, f64::INFINITY); 2]; // load and clearance
        for (&(body, ball), force) in robot.contacts.iter().zip(normal_forces(truth)) {
            let point = states[body].pose * Point3::from(ball.at) - Vector3::z() * ball.radius;
            let has_ground = robot.bodies[body].tiles.is_none_or(|tiles| tiles.has_ground_at(point.x));
            let height = if has_ground { point.z - robot.ground.height(point.x, point.y) } else { f64::INFINITY };
            let feet = robot.feet.iter().flatten().zip(&mut on_feet);
            for (_, (load, clearance)) in feet.filter(|(foot, _)| foot.body == body) {
                (*load, *clearance) = (*load + force, clearance.min(height));
            }
            load += force;
            moment += force * point.xy().coords;
            clearance = clearance.min(height);
            lowest_point = lowest_point.min(point.z);
        }
        let zmp = if load > 0.0 { moment / load } else { Vector2::repeat(f64::NAN) };
        let trunk = robot.bodies.get(robot.trunk).map(|body| (states[robot.trunk].pose, body));
        DerivedState {
            time: truth.stamp.time(),
            com,
            com_velocity,
            soles: robot.feet.as_ref().map(|feet| [0, 1].map(|k| sole(&feet[k], states, on_feet[k], zmp))),
            zmp,
            load,
            clearance,
            lowest_point,
            trunk_height: trunk.map_or(f64::NAN, |(pose, body)| (pose * Point3::from(body.com)).z),
            trunk_tilt: trunk.map_or(f64::NAN, |(pose, _)| tilt(pose.rotation * Vector3::z())),
        }
    }

    /// Index of the foot with the greater load. `None` in flight or without feet.
    pub fn loaded_foot(&self) -> Option<usize> {
        let [left, right] = self.soles.as_ref()?;
        (left.load + right.load > 0.0).then_some(usize::from(right.load > left.load))
    }

    /// The support foot in single support, and its sole.
    pub fn single_support(&self) -> Option<(usize, &SoleState)> {
        match self.soles.as_ref()? {
            [left, right] if right.load == 0.0 && left.load > 0.0 => Some((0, left)),
            [left, right] if left.load == 0.0 && right.load > 0.0 => Some((1, right)),
            _ => None,
        }
    }
}

/// Normal forces on the contact points in wire order [N].
pub fn normal_forces(truth: &Truth) -> [f64; CONTACTS] {
    std::array::from_fn(|i| truth.contact_force[3 * i + 2])
}

fn sole(foot: &FootGeometry, states: &[BodyState], (load, clearance): (f64, f64), zmp: Vector2<f64>) -> SoleState {
    let pose = states[foot.body].pose;
    let centre = (pose * foot.sole).coords;
    let (forward, up) = (pose.rotation * Vector3::x(), pose.rotation * Vector3::z());
    let heading = forward.xy().try_normalize(0.0).unwrap_or(Vector2::x());
    let mut sole = SoleState { centre, heading, tilt: tilt(up), load, clearance, zmp_margin: 0.0 };
    sole.zmp_margin = foot.margin(sole.offset_to(zmp));
    sole
}

impl SoleState {
    /// Heading of the foot [rad].
    pub fn yaw(&self) -> f64 {
        self.heading.y.atan2(self.heading.x)
    }

    /// Vector from the sole's centre to a point on the ground: components along the heading and to its left [m].
    pub fn offset_to(&self, point: Vector2<f64>) -> Vector2<f64> {
        let offset = point - self.centre.xy();
        Vector2::new(self.heading.dot(&offset), self.heading.perp(&offset))
    }
}

/// Angle between a unit vector and the vertical [rad]. Accurate near zero, unlike the arc cosine.
fn tilt(up: Vector3<f64>) -> f64 {
    up.xy().norm().atan2(up.z)
}
