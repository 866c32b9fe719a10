//! Forward kinematics: pose and velocity of every body from the generalised coordinates in a [`Truth`].
//!
//! This module does not use the plant's kinematics. A record may contain a scene that the plant refuses, or come from
//! another plant program. It must be shown as received, independently of our model. A test compares both kinematics.

use super::foot_geometry::FootGeometry;
use messages::robot::{Body, JointKind, LEFT_FOOT, RIGHT_FOOT, Sphere, TRUNK};
use messages::rotation::{aligned_axis, rotated, sin_cos_all};
use messages::scene::{Ground, Scene};
use messages::wire::{CONTACTS, JOINTS, Truth};
use nalgebra::{IsometryMatrix3, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// Joints of a leg in wire order, from the left foot up, as in Table 1.
pub const LEG_JOINTS: [&str; 4] = ["ankle roll", "ankle pitch", "knee", "hip"];

/// The scene's robot as a kinematic tree.
pub struct KinematicTree {
    /// Name of the robot.
    pub name: String,
    /// Bodies in the order of the scene.
    pub bodies: Vec<Body>,
    /// Contact points (radius zero) and contact spheres in wire order, each with the index of its body.
    pub contacts: Vec<(usize, Sphere)>,
    /// Left and right foot, if the robot has both.
    pub feet: Option<[FootGeometry; 2]>,
    /// Heights of the ground.
    pub ground: Ground,
    /// Height above the sole at which the scene's controller keeps the centre of mass [m].
    pub commanded_com_height: Option<f64>,
    /// Index of the body that fall detection observes: the trunk, or the base if no body has that name.
    pub trunk: usize,
    /// Joints, parents before children.
    joints: Vec<TreeJoint>,
    /// Body, position in its frame [m] and mass [kg]: the bodies' centres of mass, then the payload.
    point_masses: Vec<(usize, Point3<f64>, f64)>,
    /// Total mass, with the payload [kg].
    pub mass: f64,
}

/// Pose and velocity of one body in W.
#[derive(Clone, Copy)]
pub struct BodyState {
    /// Transform from the body frame to W.
    pub pose: IsometryMatrix3<f64>,
    /// Velocity of the frame's origin [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity [rad/s].
    pub spin: Vector3<f64>,
}

/// A joint, and the body that it moves.
struct TreeJoint {
    body: usize,
    parent: usize,
    /// Index of the joint in wire order.
    index: usize,
    kind: JointKind,
    /// Unit vector in the parent's frame.
    axis: Vector3<f64>,
    /// Index of the coordinate axis to which `axis` is parallel, if any: such a rotation needs fewer operations.
    aligned_axis: Option<usize>,
    /// Position of the joint in the parent's frame [m].
    origin: Vector3<f64>,
}

impl KinematicTree {
    /// The tree of the scene's bodies. A body without a connection to the base gets the pose of the base.
    pub fn new(scene: &Scene) -> Self {
        let bodies = scene.bodies.clone();
        let find = |name: &str| bodies.iter().position(|body| body.name == name);
        let base = scene.base_body();
        let or_base = |name: &str| find(name).unwrap_or(base);
        let contacts = (bodies.iter().enumerate())
            .flat_map(|(i, body)| body.contact_spheres().map(move |ball| (i, ball)))
            .take(CONTACTS)
            .collect();
        let mut point_masses: Vec<_> =
            (bodies.iter().enumerate()).map(|(i, body)| (i, body.com.into(), body.mass)).collect();
        if !bodies.is_empty() {
            let plant = &scene.plant;
            point_masses.push((or_base(&plant.payload_body), plant.payload_offset.into(), plant.payload_kg));
        }
        let feet = find(LEFT_FOOT)
            .zip(find(RIGHT_FOOT))
            .map(|(left, right)| [left, right].map(|i| FootGeometry::new(i, &bodies[i])));
        let (trunk, joints) = (or_base(TRUNK), sorted_joints(&bodies, base));
        let mass = point_masses.iter().map(|point| point.2).sum();
        KinematicTree {
            name: scene.robot_name().into(),
            bodies,
            contacts,
            feet,
            ground: scene.plant.ground.clone(),
            commanded_com_height: scene.controller.as_ref().map(|controller| controller.com_height),
            trunk,
            joints,
            point_masses,
            mass,
        }
    }

    /// Names of the joints in wire order. A joint has the name of the body that it moves.
    pub fn joint_names(&self) -> Vec<&str> {
        self.bodies.iter().filter(|body| body.joint.is_some()).map(|body| body.name.as_str()).collect()
    }

    /// Names of the joints for drawings, in wire order. Those of a biped have the names of Table 1, whatever its bodies are called.
    pub fn joint_labels(&self) -> Vec<String> {
        let bodies = self.joint_names();
        if self.feet.is_none() || bodies.len() != JOINTS {
            return bodies.into_iter().map(Into::into).collect();
        }
        let left = LEG_JOINTS.iter().map(|joint| format!("left {joint}"));
        left.chain(LEG_JOINTS.iter().rev().map(|joint| format!("right {joint}"))).collect()
    }

    /// Pose and velocity of every body in W, in the order of the scene.
    pub fn body_states(&self, truth: &Truth) -> Vec<BodyState> {
        let mut states = Vec::new();
        self.body_states_into(truth, &mut states);
        states
    }

    /// As [`KinematicTree::body_states`], into an existing buffer.
    pub fn body_states_into(&self, truth: &Truth, states: &mut Vec<BodyState>) {
        let [w, x, y, z] = truth.base_orientation;
        let base = BodyState {
            pose: IsometryMatrix3::from_parts(
                truth.base_position.into(),
                UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).into(),
            ),
            velocity: truth.base_velocity.into(),
            spin: truth.base_spin.into(),
        };
        states.clear();
        states.resize(self.bodies.len(), base);
        let mut sines_and_cosines = [(0.0, 1.0); JOINTS];
        sin_cos_all(&truth.angle, &mut sines_and_cosines);
        for joint in &self.joints {
            let k = joint.index;
            let (position, sine_cosine, rate) =
                if k < JOINTS { (truth.angle[k], sines_and_cosines[k], truth.rate[k]) } else { (0.0, (0.0, 1.0), 0.0) };
            states[joint.body] = joint.child_state(&states[joint.parent], position, sine_cosine, rate);
        }
    }

    /// Kinetic energy of the bodies and the payload [J].
    pub fn kinetic(&self, states: &[BodyState]) -> f64 {
        let translational = self.point_masses.iter().map(|&(body, position, mass)| {
            let BodyState { pose, velocity, spin } = &states[body];
            0.5 * mass * (velocity + spin.cross(&(pose.rotation * position.coords))).norm_squared()
        });
        let rotational = self.bodies.iter().zip(states).map(|(body, BodyState { pose, spin, .. })| {
            let body_spin = pose.rotation.inverse() * spin;
            0.5 * body_spin.component_mul(&body_spin).dot(&Vector3::from(body.moments()))
        });
        translational.sum::<f64>() + rotational.sum::<f64>()
    }

    /// Centre of mass of a body with its payload, in W [m], and its velocity [m/s]. Zero without mass.
    pub fn centre(&self, states: &[BodyState], body: usize) -> (Vector3<f64>, Vector3<f64>) {
        let of_body = self.point_masses.iter().filter(|point| point.0 == body);
        let (moment, mass) = of_body.fold((Vector3::zeros(), 0.0), |(moment, sum), &(_, position, mass)| {
            (moment + mass * position.coords, sum + mass)
        });
        if mass <= 0.0 {
            return (Vector3::zeros(), Vector3::zeros());
        }
        let BodyState { pose, velocity, spin } = &states[body];
        let arm = pose.rotation * (moment / mass);
        (pose.translation.vector + arm, velocity + spin.cross(&arm))
    }

    /// Height of the lowest point of a contact sphere [m].
    pub fn height(&self, states: &[BodyState], body: usize, ball: &Sphere) -> f64 {
        (states[body].pose * Point3::from(ball.at)).z - ball.radius
    }

    /// Centre of mass in W [m] and its velocity [m/s]. NaN for a robot without mass.
    pub fn com(&self, states: &[BodyState]) -> (Vector3<f64>, Vector3<f64>) {
        let mut sum = (Vector3::zeros(), Vector3::zeros());
        for &(body, position, mass) in &self.point_masses {
            let arm = states[body].pose.rotation * position.coords;
            sum.0 += mass * (states[body].pose.translation.vector + arm);
            sum.1 += mass * (states[body].velocity + states[body].spin.cross(&arm));
        }
        (sum.0 / self.mass, sum.1 / self.mass)
    }
}

impl TreeJoint {
    /// State of the child body for a joint position, its sine and cosine, and the joint rate.
    fn child_state(&self, parent: &BodyState, position: f64, sine_cosine: (f64, f64), rate: f64) -> BodyState {
        let rotation = &parent.pose.rotation;
        let axis = rotation * self.axis;
        let joint_origin = rotation * self.origin;
        let (turned, arm, joint_velocity, joint_spin) = match self.kind {
            JointKind::Revolute => {
                let turned = rotated(rotation.matrix(), &self.axis, self.aligned_axis, sine_cosine);
                (Rotation3::from_matrix_unchecked(turned), joint_origin, Vector3::zeros(), axis * rate)
            }
            JointKind::Prismatic => (*rotation, joint_origin + axis * position, axis * rate, Vector3::zeros()),
        };
        let origin = parent.pose.translation.vector + arm;
        BodyState {
            pose: IsometryMatrix3::from_parts(origin.into(), turned),
            velocity: parent.velocity + parent.spin.cross(&arm) + joint_velocity,
            spin: parent.spin + joint_spin,
        }
    }
}

/// The joints that are connected to the base, parents before children.
fn sorted_joints(bodies: &[Body], base: usize) -> Vec<TreeJoint> {
    let mut remaining: Vec<TreeJoint> = (bodies.iter().enumerate())
        .filter_map(|(i, body)| body.joint.as_ref().map(|joint| (i, joint)))
        .enumerate()
        .filter_map(|(number, (body, joint))| {
            let parent = bodies.iter().position(|other| other.name == joint.parent)?;
            let axis = Vector3::from(joint.axis).normalize();
            let aligned_axis = aligned_axis(&axis);
            Some(TreeJoint {
                body,
                parent,
                index: number,
                kind: joint.kind,
                axis,
                aligned_axis,
                origin: joint.at.into(),
            })
        })
        .collect();
    let (mut reached, mut joints) = (vec![base], Vec::new());
    while let Some(next) = remaining.iter().position(|joint| reached.contains(&joint.parent)) {
        reached.push(remaining[next].body);
        joints.push(remaining.remove(next));
    }
    joints
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::synthetic::SyntheticWalk;
    use messages::load::load;
    use messages::wire::Torques;
    use plant::kinematics::{self, Pose};
    use shared::list::SCENES;

    #[test]
    fn the_kinematics_equal_those_of_the_plant() {
        for name in ["free", "stand0", "rock"] {
            let scene = load(name, &[], SCENES).unwrap();
            let mut plant = plant::Plant::new(&scene).unwrap();
            for _ in 0..50 {
                plant.advance(&Torques::default()).unwrap();
            }
            let pose = Pose::of(plant.model(), plant.state());
            let totals = kinematics::totals(plant.model(), plant.state(), &pose);
            let robot = KinematicTree::new(&scene);
            let states = robot.body_states(&plant.truth());
            let (com, velocity) = robot.com(&states);
            let error = (com - totals.com).norm().max((velocity - totals.com_velocity).norm());
            let ends = plant.model().body_link.iter().zip(&states).map(|(&link, body)| {
                let point = Vector3::new(0.3, -0.2, 0.1);
                (pose.point(link, &point) - (body.pose * Point3::from(point)).coords).norm()
            });
            assert!(ends.fold(error, f64::max) < 1e-12, "{name}: off by {error:e}");
        }
    }

    #[test]
    fn velocities_are_the_derivatives_of_positions() {
        let (walk, robot) = (SyntheticWalk::new(0.06), KinematicTree::new(&Scene::default()));
        for time in [1.0, 1.7, 3.21, 5.05] {
            let com = |time| robot.com(&robot.body_states(&walk.truth(0, time)));
            let slope = (com(time + 1e-5).0 - com(time - 1e-5).0) / 2e-5;
            let error = (slope - com(time).1).norm();
            assert!(error < 1e-6, "CoM velocity off by {error} m/s at {time} s");
        }
    }

    #[test]
    fn a_payload_moves_the_centre_of_mass() {
        let mut scene = Scene::default();
        let truth = Truth { base_orientation: [1.0, 0.0, 0.0, 0.0], ..Truth::default() };
        let com = |scene: &Scene| {
            let robot = KinematicTree::new(scene);
            robot.com(&robot.body_states(&truth)).0
        };
        let before = com(&scene);
        (scene.plant.payload_kg, scene.plant.payload_offset) = (2.0, [0.1, 0.0, 0.3]);
        let expected = (before * 14.0 + Vector3::new(0.2, 0.0, 0.6)) / 16.0;
        assert!((com(&scene) - expected).norm() < 1e-14);
        // The upright robot of Table 1, from the trunk's centre .65 m above the soles.
        assert!((before.z + 0.65 - 0.3196).abs() < 5e-5, "{before}");
    }
}
