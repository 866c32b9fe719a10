//! What one [`Truth`] says about the whole robot: centre of mass, soles, loads, zero-moment point.

use super::kinematic_tree::{BodyState, FootGeometry, KinematicTree};
use messages::wire::{CONTACTS, Truth};
use nalgebra::{Point3, Vector2, Vector3};

/// Everything derived from one derived; world frame W.
#[derive(Clone, Debug)]
pub struct DerivedState {
    /// Simulated time [s].
    pub time: f64,
    /// Centre of mass [m].
    pub com: Vector3<f64>,
    /// Its velocity [m/s].
    pub com_velocity: Vector3<f64>,
    /// Soles of the left and right foot.
    pub soles: Option<[SoleState; 2]>,
    /// Zero-moment point on the ground, x and y [m]; NaN while nothing carries the robot.
    pub zmp: Vector2<f64>,
    /// Normal force on all contact points together [N].
    pub load: f64,
    /// Height of the lowest contact point [m]; infinite if the robot has none.
    pub clearance: f64,
    /// Height of the trunk's centre of mass [m].
    pub trunk_height: f64,
    /// Angle between the trunk's and the world's vertical [rad].
    pub trunk_tilt: f64,
}

/// The sole of one foot.
#[derive(Clone, Copy, Debug)]
pub struct SoleState {
    /// Its centre [m].
    pub centre: Vector3<f64>,
    /// Heading of the foot on the ground, a unit vector.
    pub heading: Vector2<f64>,
    /// Angle between the sole and the ground [rad].
    pub tilt: f64,
    /// Normal force on its contact points [N].
    pub load: f64,
    /// Least distance of the zero-moment point inside the sole's edge; negative outside [m].
    pub zmp_margin: f64,
}

impl DerivedState {
    /// Derives everything from one record; `placed` as [`KinematicTree::body_states`] gives it for the same record.
    pub fn new(robot: &KinematicTree, truth: &Truth, placed: &[BodyState]) -> Self {
        let (com, com_velocity) = robot.com(placed);
        let (mut load, mut moment, mut clearance) = (0.0, Vector2::zeros(), f64::INFINITY);
        for (&(body, ball), force) in robot.contacts.iter().zip(normal_forces(truth)) {
            let point = placed[body].pose * Point3::from(ball.at) - Vector3::z() * ball.radius;
            load += force;
            moment += force * point.xy().coords;
            clearance = clearance.min(point.z);
        }
        let zmp = if load > 0.0 { moment / load } else { Vector2::repeat(f64::NAN) };
        let trunk = robot.bodies.get(robot.trunk).map(|body| (placed[robot.trunk].pose, body));
        DerivedState {
            time: truth.stamp.sim_ns as f64 * 1e-9,
            com,
            com_velocity,
            soles: robot.feet.as_ref().map(|feet| feet.each_ref().map(|foot| sole(robot, truth, placed, foot, zmp))),
            zmp,
            load,
            clearance,
            trunk_height: trunk.map_or(f64::NAN, |(pose, body)| (pose * Point3::from(body.com)).z),
            trunk_tilt: trunk.map_or(f64::NAN, |(pose, _)| tilt(pose.rotation * Vector3::z())),
        }
    }

    /// Index of the foot that carries more; `None` in the air or without feet.
    pub fn loaded_foot(&self) -> Option<usize> {
        let [left, right] = self.soles.as_ref()?;
        (left.load + right.load > 0.0).then_some(usize::from(right.load > left.load))
    }

    /// The only foot that carries, if it carries everything.
    pub fn single_support(&self) -> Option<&SoleState> {
        match self.soles.as_ref()? {
            [left, right] if right.load == 0.0 && left.load > 0.0 => Some(left),
            [left, right] if left.load == 0.0 && right.load > 0.0 => Some(right),
            _ => None,
        }
    }
}

/// Normal forces on the contact points in wire order [N].
pub fn normal_forces(truth: &Truth) -> [f64; CONTACTS] {
    std::array::from_fn(|i| truth.contact_force[3 * i + 2])
}

fn sole(
    robot: &KinematicTree,
    truth: &Truth,
    placed: &[BodyState],
    foot: &FootGeometry,
    zmp: Vector2<f64>,
) -> SoleState {
    let pose = placed[foot.body].pose;
    let centre = (pose * foot.sole).coords;
    let (forward, up) = (pose.rotation * Vector3::x(), pose.rotation * Vector3::z());
    let load = (robot.contacts.iter().zip(normal_forces(truth)))
        .filter(|((body, _), _)| *body == foot.body)
        .map(|(_, force)| force)
        .sum();
    let heading = forward.xy().try_normalize(0.0).unwrap_or(Vector2::x());
    let mut sole = SoleState { centre, heading, tilt: tilt(up), load, zmp_margin: 0.0 };
    let arm = sole.arm(zmp);
    sole.zmp_margin = (foot.half[0] - arm.x.abs()).min(foot.half[1] - arm.y.abs());
    sole
}

impl SoleState {
    /// Heading of the foot [rad].
    pub fn yaw(&self) -> f64 {
        self.heading.y.atan2(self.heading.x)
    }

    /// From the sole's centre to a point on the ground: along the heading, and to the left of it [m].
    pub fn arm(&self, point: Vector2<f64>) -> Vector2<f64> {
        let arm = point - self.centre.xy();
        Vector2::new(self.heading.dot(&arm), self.heading.perp(&arm))
    }
}

/// Angle of a unit vector to the vertical [rad], exact near zero.
fn tilt(up: Vector3<f64>) -> f64 {
    up.xy().norm().atan2(up.z)
}
