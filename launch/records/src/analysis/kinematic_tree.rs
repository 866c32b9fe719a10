//! Where the bodies of a scene are and how they move, from the pose in a [`Truth`].
//!
//! Not by the plant's kinematics: a record may be of a scene that the plant refuses, or of another program's plant, and what it
//! shows is to be the wire's and not the model's. A test holds the two together.

use messages::robot::{Body, JointKind, LEFT_FOOT, RIGHT_FOOT, Sphere, TRUNK};
use messages::scene::Scene;
use messages::turn::{along, sines_cosines, turned};
use messages::wire::{CONTACTS, JOINTS, Truth};
use nalgebra::{IsometryMatrix3, Point3, Quaternion, Rotation3, UnitQuaternion, Vector3};

/// The scene's robot, arranged for walking the tree from the base outwards.
pub struct KinematicTree {
    /// What it is called.
    pub name: String,
    /// Bodies as in the scene.
    pub bodies: Vec<Body>,
    /// Contact points and balls in wire order, each with its body.
    pub contacts: Vec<(usize, Sphere)>,
    /// Left and right foot, if the robot has both.
    pub feet: Option<[FootGeometry; 2]>,
    /// The body that falls: the trunk if one has that name, else the base.
    pub trunk: usize,
    links: Vec<TreeJoint>,
    point_masses: Vec<(usize, Point3<f64>, f64)>,
    /// Total mass, with the payload [kg].
    pub mass: f64,
}

/// A foot and its flat rectangular sole.
pub struct FootGeometry {
    /// Index of the body.
    pub body: usize,
    /// Centre of the sole in the body's frame [m].
    pub sole: Point3<f64>,
    /// Half the depth and half the width of the sole [m].
    pub half: [f64; 2],
}

/// Pose and velocity of one body in W.
#[derive(Clone, Copy)]
pub struct BodyState {
    /// Body frame to W.
    pub pose: IsometryMatrix3<f64>,
    /// Velocity of the frame's origin [m/s].
    pub velocity: Vector3<f64>,
    /// Angular velocity [rad/s].
    pub spin: Vector3<f64>,
}

struct TreeJoint {
    body: usize,
    parent: usize,
    joint: usize,
    kind: JointKind,
    axis: Vector3<f64>,
    along: Option<usize>,
    at: Vector3<f64>,
}

impl KinematicTree {
    /// Arranges the scene's bodies. Bodies that hang from nothing stay at the base.
    pub fn new(scene: &Scene) -> Self {
        let bodies = scene.bodies.clone();
        let find = |name: &str| bodies.iter().position(|body| body.name == name);
        let base = bodies.iter().position(|body| body.joint.is_none()).unwrap_or(0);
        let or_base = |name: &str| find(name).unwrap_or(base);
        let contacts = (bodies.iter().enumerate())
            .flat_map(|(i, body)| body.touchable().map(move |ball| (i, ball)))
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
        let (trunk, links) = (or_base(TRUNK), links(&bodies, base));
        let mass = point_masses.iter().map(|lump| lump.2).sum();
        KinematicTree { name: scene.robot_name().into(), bodies, contacts, feet, trunk, links, point_masses, mass }
    }

    /// Names of the joints, in wire order: those of the bodies that they move.
    pub fn joint_names(&self) -> Vec<&str> {
        self.bodies.iter().filter(|body| body.joint.is_some()).map(|body| body.name.as_str()).collect()
    }

    /// Pose and velocity of every body in W, in the scene's order.
    pub fn body_states(&self, truth: &Truth) -> Vec<BodyState> {
        let mut placed = Vec::new();
        self.body_states_into(truth, &mut placed);
        placed
    }

    /// The same, in a list that there is.
    pub fn body_states_into(&self, truth: &Truth, placed: &mut Vec<BodyState>) {
        let [w, x, y, z] = truth.base_orientation;
        let base = BodyState {
            pose: IsometryMatrix3::from_parts(
                truth.base_position.into(),
                UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z)).into(),
            ),
            velocity: truth.base_velocity.into(),
            spin: truth.base_spin.into(),
        };
        placed.clear();
        placed.resize(self.bodies.len(), base);
        let mut turns = [(0.0, 1.0); JOINTS];
        sines_cosines(&truth.angle, &mut turns);
        for link in &self.links {
            let k = link.joint;
            let (travel, turn, rate) =
                if k < JOINTS { (truth.angle[k], turns[k], truth.rate[k]) } else { (0.0, (0.0, 1.0), 0.0) };
            placed[link.body] = link.carry(&placed[link.parent], travel, turn, rate);
        }
    }

    /// Kinetic energy of the bodies, payload included [J].
    pub fn kinetic(&self, placed: &[BodyState]) -> f64 {
        let straight = self.point_masses.iter().map(|&(body, place, mass)| {
            let BodyState { pose, velocity, spin } = &placed[body];
            0.5 * mass * (velocity + spin.cross(&(pose.rotation * place.coords))).norm_squared()
        });
        let round = self.bodies.iter().zip(placed).map(|(body, BodyState { pose, spin, .. })| {
            let own = pose.rotation.inverse() * spin;
            0.5 * own.component_mul(&own).dot(&Vector3::from(body.moments()))
        });
        straight.sum::<f64>() + round.sum::<f64>()
    }

    /// Centre of mass of a body in W [m].
    pub fn centre(&self, placed: &[BodyState], body: usize) -> Vector3<f64> {
        let own = self.bodies.get(body).zip(placed.get(body));
        own.map_or(Vector3::zeros(), |(body, placed)| (placed.pose * Point3::from(body.com)).coords)
    }

    /// Height of a contact point, or of the lowest point of a ball [m].
    pub fn height(&self, placed: &[BodyState], body: usize, ball: &Sphere) -> f64 {
        (placed[body].pose * Point3::from(ball.at)).z - ball.radius
    }

    /// Centre of mass in W [m] and its velocity [m/s]; NaN if the robot weighs nothing.
    pub fn com(&self, placed: &[BodyState]) -> (Vector3<f64>, Vector3<f64>) {
        let mut sum = (Vector3::zeros(), Vector3::zeros());
        for &(body, place, mass) in &self.point_masses {
            let arm = placed[body].pose.rotation * place.coords;
            sum.0 += mass * (placed[body].pose.translation.vector + arm);
            sum.1 += mass * (placed[body].velocity + placed[body].spin.cross(&arm));
        }
        (sum.0 / self.mass, sum.1 / self.mass)
    }
}

impl FootGeometry {
    /// The sole spans the body's contact points; without any it is the bottom of the box.
    fn new(index: usize, body: &Body) -> Self {
        let [depth, width, height] = body.size;
        if body.contacts.is_empty() {
            let sole = Point3::from(body.com) - Vector3::z() * height / 2.0;
            return FootGeometry { body: index, sole, half: [depth / 2.0, width / 2.0] };
        }
        let span = |axis: usize| {
            let values = body.contacts.iter().map(move |point| point[axis]);
            (values.clone().fold(f64::INFINITY, f64::min), values.fold(f64::NEG_INFINITY, f64::max))
        };
        let [x, y, z] = [span(0), span(1), span(2)];
        let sole = Point3::new((x.0 + x.1) / 2.0, (y.0 + y.1) / 2.0, z.0);
        FootGeometry { body: index, sole, half: [(x.1 - x.0) / 2.0, (y.1 - y.0) / 2.0] }
    }
}

impl TreeJoint {
    /// The body beyond a joint that has gone so far, the sine and cosine of which are `turn`, at this rate.
    fn carry(&self, parent: &BodyState, travel: f64, turn: (f64, f64), rate: f64) -> BodyState {
        let rotation = &parent.pose.rotation;
        let axis = rotation * self.axis;
        let hinge = rotation * self.at;
        let (turned, arm, sliding, turning) = match self.kind {
            JointKind::Revolute => {
                let turned = turned(rotation.matrix(), &self.axis, self.along, turn);
                (Rotation3::from_matrix_unchecked(turned), hinge, Vector3::zeros(), axis * rate)
            }
            JointKind::Prismatic => (*rotation, hinge + axis * travel, axis * rate, Vector3::zeros()),
        };
        let origin = parent.pose.translation.vector + arm;
        BodyState {
            pose: IsometryMatrix3::from_parts(origin.into(), turned),
            velocity: parent.velocity + parent.spin.cross(&arm) + sliding,
            spin: parent.spin + turning,
        }
    }
}

/// Joints of the tree, parents first.
fn links(bodies: &[Body], base: usize) -> Vec<TreeJoint> {
    let mut open: Vec<TreeJoint> = (bodies.iter().enumerate())
        .filter_map(|(i, body)| body.joint.as_ref().map(|joint| (i, joint)))
        .enumerate()
        .filter_map(|(number, (body, joint))| {
            let parent = bodies.iter().position(|other| other.name == joint.parent)?;
            let axis = Vector3::from(joint.axis).normalize();
            let along = along(&axis);
            Some(TreeJoint { body, parent, joint: number, kind: joint.kind, axis, along, at: joint.at.into() })
        })
        .collect();
    let (mut reached, mut links) = (vec![base], Vec::new());
    while let Some(next) = open.iter().position(|link| reached.contains(&link.parent)) {
        reached.push(open[next].body);
        links.push(open.remove(next));
    }
    links
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
    fn the_record_sees_what_the_plant_sees() {
        for name in ["free", "stand0", "rock"] {
            let scene = load(name, &[], SCENES).unwrap();
            let mut plant = plant::Plant::new(&scene).unwrap();
            for _ in 0..50 {
                plant.advance(&Torques::default()).unwrap();
            }
            let mut pose = Pose::new(plant.model());
            kinematics::pose(plant.model(), plant.state(), &mut pose);
            let totals = kinematics::totals(plant.model(), plant.state(), &pose);
            let robot = KinematicTree::new(&scene);
            let placed = robot.body_states(&plant.truth());
            let (com, velocity) = robot.com(&placed);
            let off = (com - totals.com).norm().max((velocity - totals.com_velocity).norm());
            let ends = plant.model().body_link.iter().zip(&placed).map(|(&link, body)| {
                let at = Vector3::new(0.3, -0.2, 0.1);
                (pose.point(link, &at) - (body.pose * Point3::from(at)).coords).norm()
            });
            assert!(ends.fold(off, f64::max) < 1e-12, "{name}: off by {off:e} in the mass");
        }
    }

    #[test]
    fn rates_and_poses_belong_together() {
        let (fake, robot) = (SyntheticWalk::new(0.06), KinematicTree::new(&Scene::default()));
        for time in [1.0, 1.7, 3.21, 5.05] {
            let com = |time| robot.com(&robot.body_states(&fake.truth(0, time)));
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
