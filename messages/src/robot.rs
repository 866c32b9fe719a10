//! Robots as data: a tree of bodies. Each body except the base has one joint to its parent.
//!
//! [`table_1`] is the robot of Fujimoto & Kawamura (1995), Table 1. All frames are parallel to the world frame W
//! (x forward, y left, z up) when every joint angle is zero.

mod biped;
mod shape;
mod similarity;
mod sole;

pub use biped::canonical_biped;
pub use shape::{require_biped_tree, require_few_joints};
pub use similarity::{SimilarityScale, stance};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Kind of a joint.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum JointKind {
    /// Rotation about the axis [rad].
    #[default]
    Revolute,
    /// Translation along the axis [m].
    Prismatic,
}

/// The joint between a body and its parent.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Joint {
    /// Name of the parent body.
    pub parent: String,
    /// Revolute (default) or prismatic.
    #[serde(default)]
    pub kind: JointKind,
    /// Axis of motion of this body relative to its parent, in the common frame at zero angles [-].
    pub axis: [f64; 3],
    /// Position of the joint in the parent's frame. It is the origin of this body's frame at joint position zero [m].
    pub at: [f64; 3],
    /// Stiffness of a spring in the joint, which is unloaded at `rest` [N·m/rad or N/m].
    #[serde(default)]
    pub stiffness: f64,
    /// Damping of this joint, in addition to `plant.joint_damping` [N·m·s/rad or N·s/m].
    #[serde(default)]
    pub damping: f64,
    /// Joint position at which the spring is unloaded [rad or m].
    #[serde(default)]
    pub rest: f64,
}

/// A ball fixed to a body. Its lowest point touches the ground, so it rolls.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Sphere {
    /// Centre in the body's frame [m].
    pub at: [f64; 3],
    /// Radius [m].
    pub radius: f64,
}

/// Ground that consists of tiles along x with holes between them. A swing foot may dip into a hole.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Tiles {
    /// Position of the centre of one tile, x in W [m].
    pub first: f64,
    /// Distance between the centres of two tiles [m].
    pub pitch: f64,
    /// Length of a tile [m].
    pub length: f64,
}

impl Tiles {
    /// Whether there is ground at x [m].
    pub fn has_ground_at(&self, x: f64) -> bool {
        let from_middle = x - self.first;
        (from_middle - self.pitch * (from_middle / self.pitch).round()).abs() <= 0.5 * self.length
    }
}

/// One rigid body.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Body {
    /// Unique name.
    pub name: String,
    /// Mass [kg].
    pub mass: f64,
    /// Depth, width and height of the box that is drawn. Unless `inertia` is given, it has uniform density [m].
    pub size: [f64; 3],
    /// Centre of mass, also the centre of the box, in the body's frame [m].
    #[serde(default)]
    pub com: [f64; 3],
    /// Principal moments of inertia about the centre of mass along the body's axes [kg·m²]; absent: uniform box.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub inertia: Option<[f64; 3]>,
    /// Joint to the parent. Exactly one body of a scene, the base, has none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub joint: Option<Joint>,
    /// Points that may touch the ground, in the body's frame [m].
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub contacts: Vec<[f64; 3]>,
    /// Balls that may touch the ground. Each rolls on its lowest point.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub spheres: Vec<Sphere>,
    /// Tiles on which this body's points and balls find ground; absent: ground everywhere.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tiles: Option<Tiles>,
}

impl Body {
    /// Principal moments of inertia about the centre of mass [kg·m²]: as given, or m(b² + c²)/12 of a uniform box.
    pub fn moments(&self) -> [f64; 3] {
        let [a, b, c] = self.size.map(|side| side * side);
        self.inertia.unwrap_or([b + c, a + c, a + b].map(|sum| self.mass * sum / 12.0))
    }

    /// Inertias that a force on the body may meet [kg]: its mass, and its moments of inertia over the square of its reach, which is the
    /// distance of its farthest point, along an axis of its frame.
    pub fn inertias(&self) -> [f64; 4] {
        let balls = self.contact_spheres().map(|ball| ball.at.map(|part| part.abs() + ball.radius));
        let reach = balls.chain([self.size, self.com]).flatten().fold(0.0, |most: f64, part| most.max(part.abs()));
        let [a, b, c] = self.moments().map(|moment| moment / (reach * reach));
        [self.mass, a, b, c]
    }

    /// Contact points and balls in the order of the messages: first the points, as balls of radius 0, then the balls.
    pub fn contact_spheres(&self) -> impl Iterator<Item = Sphere> + '_ {
        let points = self.contacts.iter().map(|&at| Sphere { at, radius: 0.0 });
        points.chain(self.spheres.iter().copied())
    }
}

/// A robot in a file of its own: a biped that replaces the one of Table 1.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, expecting = "a table")]
pub struct Robot {
    /// Name in results; absent: the name of the file.
    #[serde(default)]
    pub name: String,
    /// Its drives.
    #[serde(default)]
    pub drives: DriveParameters,
    /// A trunk and two legs. If the right leg is absent, it is the mirror image of the left one.
    pub bodies: Vec<Body>,
}

/// The drives of a robot, all equal. An absent value is that of the robot that this one replaces, scaled by dynamic similarity.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default, expecting = "a table")]
pub struct DriveParameters {
    /// Inertia reflected at each joint, J_r [kg·m²].
    pub inertia: Option<f64>,
    /// Viscous damping of each joint, D [N·m·s/rad].
    pub damping: Option<f64>,
    /// Greatest torque [N·m].
    pub torque_limit: Option<f64>,
    /// Encoder resolution: counts per turn are 2 to this power [bit].
    pub encoder_bits: Option<u32>,
}

/// Name of the left foot in [`table_1`].
pub const LEFT_FOOT: &str = "left foot";
/// Name of the right foot in [`table_1`].
pub const RIGHT_FOOT: &str = "right foot";
/// Name of the trunk in [`table_1`].
pub const TRUNK: &str = "trunk";
/// Canonical names and order of a biped's bodies, from the left foot to the right foot.
pub const BIPED: [&str; 9] = [
    LEFT_FOOT,
    "left ankle",
    "left shank",
    "left thigh",
    TRUNK,
    "right thigh",
    "right shank",
    "right ankle",
    RIGHT_FOOT,
];
/// Joint angles at which the robot of [`table_1`] stands with bent knees, its centre of gravity .27 m high [rad].
pub const CROUCH: [f64; 8] = [0.0, 0.4943, -1.5177, 1.0234, -1.0234, 1.5177, -0.4943, 0.0];

/// The robot of Table 1: links #0 (left foot) … #8 (right foot). In the order of the bodies the joints are left ankle roll, ankle
/// pitch, knee, hip, right hip, knee, ankle pitch, ankle roll.
///
/// The paper counts joint angles along the chain from the left foot to the right foot. Here the trunk is the base of the tree, because
/// that makes H sparsest. The axes of the left leg therefore point backwards. The "total depth 0.3" of the table contradicts its other
/// numbers and is ignored as a misprint.
pub fn table_1() -> Vec<Body> {
    let foot = |name, parent, axis| Body {
        contacts: sole_corners(),
        ..link(name, 1.0, [0.2, 0.1, 0.05], [0.0, 0.0, -0.025], parent, axis, [0.0, 0.0, -0.05])
    };
    let ankle =
        |name, parent, axis| link(name, 0.5, [0.1, 0.1, 0.05], [0.0, 0.0, -0.025], parent, axis, [0.0, 0.0, -0.2]);
    let bone = |name, parent, axis, at| link(name, 2.0, [0.1, 0.1, 0.2], [0.0, 0.0, -0.1], parent, axis, at);
    let (roll, pitch) = ([1.0, 0.0, 0.0], [0.0, 1.0, 0.0]);
    let (roll_back, pitch_back) = ([-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]);
    vec![
        foot(LEFT_FOOT, "left ankle", roll_back),
        ankle("left ankle", "left shank", pitch_back),
        bone("left shank", "left thigh", pitch_back, [0.0, 0.0, -0.2]),
        bone("left thigh", TRUNK, pitch_back, [0.0, 0.05, -0.15]),
        Body { name: TRUNK.into(), mass: 3.0, size: [0.1, 0.1, 0.3], ..Body::default() },
        bone("right thigh", TRUNK, pitch, [0.0, -0.05, -0.15]),
        bone("right shank", "right thigh", pitch, [0.0, 0.0, -0.2]),
        ankle("right ankle", "right shank", pitch),
        foot(RIGHT_FOOT, "right ankle", roll),
    ]
}

fn link(name: &str, mass: f64, size: [f64; 3], com: [f64; 3], parent: &str, axis: [f64; 3], at: [f64; 3]) -> Body {
    let joint = Joint { parent: parent.into(), axis, at, ..Joint::default() };
    Body { name: name.into(), mass, size, com, joint: Some(joint), ..Body::default() }
}

/// Corners of a sole in the foot's frame: front left, front right, back left, back right [m].
fn sole_corners() -> Vec<[f64; 3]> {
    vec![[0.1, 0.05, -0.05], [0.1, -0.05, -0.05], [-0.1, 0.05, -0.05], [-0.1, -0.05, -0.05]]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_1_weighs_fourteen_kilograms_and_stands_eighty_centimetres_tall() {
        let bodies = table_1();
        assert!((bodies.iter().map(|body| body.mass).sum::<f64>() - 14.0).abs() < 1e-12);
        let heights = bodies.iter().map(|body| {
            let above = |joint: &Joint| bodies.iter().find(|body| body.name == joint.parent);
            let chain = std::iter::successors(Some(body), |body| body.joint.as_ref().and_then(above));
            let frame: f64 = chain.filter_map(|body| body.joint.as_ref()).map(|joint| joint.at[2]).sum();
            let centre = frame + body.com[2];
            [centre - body.size[2] / 2.0, centre + body.size[2] / 2.0]
        });
        let [low, high] =
            heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], [from, to]| [low.min(from), high.max(to)]);
        assert!((high - low - 0.8).abs() < 1e-12, "{low} to {high}");
    }
}
