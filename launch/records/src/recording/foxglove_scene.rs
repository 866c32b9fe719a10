//! The robot for 3-D panels: a frame for each body, boxes fixed to the frames, and an arrow for each force of the ground.

use super::events::FoxgloveTime;
use super::mcap_file::{McapWriter, json_channel, json_message};
use crate::analysis::KinematicTree;
use mcap::McapResult;
use messages::scene::Scene;
use messages::wire::Truth;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

/// Length of an arrow [m/N].
const METRES_PER_NEWTON: f64 = 2e-3;
/// The frame of the ground.
const WORLD: &str = "world";

/// The robot, and where its pictures go.
pub(super) struct FoxgloveScene {
    robot: KinematicTree,
    frames: u16,
    forces: u16,
    boxes: u16,
    is_there: bool,
}

impl FoxgloveScene {
    /// Makes the channels.
    pub fn begin(file: &mut McapWriter, scene: &Scene) -> McapResult<FoxgloveScene> {
        Ok(FoxgloveScene {
            robot: KinematicTree::new(scene),
            frames: json_channel::<FrameTransforms>(file, "/tf", "foxglove.FrameTransforms")?,
            boxes: json_channel::<SceneUpdate>(file, "/robot", "foxglove.SceneUpdate")?,
            forces: json_channel::<SceneUpdate>(file, "/forces", "foxglove.SceneUpdate")?,
            is_there: false,
        })
    }

    /// Draws one instant.
    pub fn draw(&mut self, file: &mut McapWriter, truth: &Truth, time: u64) -> McapResult<()> {
        let timestamp = FoxgloveTime::new(time);
        let placed = self.robot.body_states(truth);
        if !std::mem::replace(&mut self.is_there, true) {
            json_message(file, self.boxes, time, &self.boxes(timestamp))?;
        }
        let transforms = self.robot.bodies.iter().zip(&placed).map(|(body, placed)| FrameTransform {
            timestamp,
            parent_frame_id: WORLD,
            child_frame_id: body.name.clone(),
            translation: placed.pose.translation.vector.into(),
            rotation: UnitQuaternion::from(placed.pose.rotation).into(),
        });
        json_message(file, self.frames, time, &FrameTransforms { transforms: transforms.collect() })?;
        let arrows =
            self.robot.contacts.iter().zip(truth.contact_force.chunks(3)).filter_map(|((body, ball), force)| {
                let force = Vector3::from_column_slice(force);
                let foot = placed[*body].pose * Point3::from(ball.at) - Vector3::z() * ball.radius;
                (force.norm() > 0.0).then(|| Arrow::new(foot, force))
            });
        let entity = Entity { arrows: arrows.collect(), ..Entity::new(timestamp, WORLD, "forces") };
        json_message(file, self.forces, time, &SceneUpdate { deletions: vec![], entities: vec![entity] })
    }

    fn boxes(&self, timestamp: FoxgloveTime) -> SceneUpdate {
        let entities = self.robot.bodies.iter().map(|body| {
            let [x, y, z] = body.size;
            let pose = Isometry3::from_parts(body.com.into(), UnitQuaternion::identity()).into();
            let cube = Cube { pose, size: FoxgloveVector { x, y, z }, color: BODY };
            Entity { cubes: vec![cube], frame_locked: true, ..Entity::new(timestamp, &body.name, &body.name) }
        });
        SceneUpdate { deletions: vec![], entities: entities.collect() }
    }
}

#[derive(Serialize, JsonSchema)]
struct FrameTransforms {
    transforms: Vec<FrameTransform>,
}

#[derive(Serialize, JsonSchema)]
struct FrameTransform {
    timestamp: FoxgloveTime,
    parent_frame_id: &'static str,
    child_frame_id: String,
    translation: FoxgloveVector,
    rotation: FoxgloveQuaternion,
}

#[derive(Serialize, JsonSchema)]
struct SceneUpdate {
    deletions: Vec<Deletion>,
    entities: Vec<Entity>,
}

#[derive(Serialize, JsonSchema)]
struct Deletion {
    timestamp: FoxgloveTime,
    r#type: u8,
    id: String,
}

#[derive(Serialize, JsonSchema)]
struct Entity {
    timestamp: FoxgloveTime,
    frame_id: String,
    id: String,
    lifetime: FoxgloveTime,
    frame_locked: bool,
    arrows: Vec<Arrow>,
    cubes: Vec<Cube>,
    #[serde(flatten)]
    unused: UnusedFields,
}

/// What else an entity may have, and readers want to find.
#[derive(Default, Serialize, JsonSchema)]
struct UnusedFields {
    metadata: [NoEntries; 0],
    spheres: [NoEntries; 0],
    cylinders: [NoEntries; 0],
    lines: [NoEntries; 0],
    triangles: [NoEntries; 0],
    texts: [NoEntries; 0],
    models: [NoEntries; 0],
}

#[derive(Serialize, JsonSchema)]
struct NoEntries {}

impl Entity {
    /// Nothing yet, for as long as nobody replaces it.
    fn new(timestamp: FoxgloveTime, frame: &str, id: &str) -> Entity {
        let lifetime = FoxgloveTime::new(0);
        Entity {
            timestamp,
            frame_id: frame.into(),
            id: id.into(),
            lifetime,
            frame_locked: false,
            arrows: vec![],
            cubes: vec![],
            unused: UnusedFields::default(),
        }
    }
}

#[derive(Serialize, JsonSchema)]
struct Arrow {
    pose: FoxglovePose,
    shaft_length: f64,
    shaft_diameter: f64,
    head_length: f64,
    head_diameter: f64,
    color: Colour,
}

impl Arrow {
    fn new(from: Point3<f64>, force: Vector3<f64>) -> Arrow {
        // An arrow points along the x axis of its pose.
        let turn = UnitQuaternion::rotation_between(&Vector3::x(), &force);
        let turn = turn.unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
        Arrow {
            pose: Isometry3::from_parts(from.into(), turn).into(),
            shaft_length: METRES_PER_NEWTON * force.norm(),
            shaft_diameter: 0.006,
            head_length: 0.02,
            head_diameter: 0.014,
            color: FORCE,
        }
    }
}

#[derive(Serialize, JsonSchema)]
struct Cube {
    pose: FoxglovePose,
    size: FoxgloveVector,
    color: Colour,
}

#[derive(Serialize, JsonSchema)]
struct FoxglovePose {
    position: FoxgloveVector,
    orientation: FoxgloveQuaternion,
}

impl From<Isometry3<f64>> for FoxglovePose {
    fn from(pose: Isometry3<f64>) -> FoxglovePose {
        FoxglovePose { position: pose.translation.vector.into(), orientation: pose.rotation.into() }
    }
}

#[derive(Serialize, JsonSchema)]
struct FoxgloveVector {
    x: f64,
    y: f64,
    z: f64,
}

impl From<Vector3<f64>> for FoxgloveVector {
    fn from(vector: Vector3<f64>) -> FoxgloveVector {
        FoxgloveVector { x: vector.x, y: vector.y, z: vector.z }
    }
}

#[derive(Serialize, JsonSchema)]
struct FoxgloveQuaternion {
    x: f64,
    y: f64,
    z: f64,
    w: f64,
}

impl From<UnitQuaternion<f64>> for FoxgloveQuaternion {
    fn from(turn: UnitQuaternion<f64>) -> FoxgloveQuaternion {
        FoxgloveQuaternion { x: turn.i, y: turn.j, z: turn.k, w: turn.w }
    }
}

#[derive(Clone, Copy, Serialize, JsonSchema)]
struct Colour {
    r: f64,
    g: f64,
    b: f64,
    a: f64,
}

const BODY: Colour = Colour { r: 0.45, g: 0.6, b: 0.8, a: 0.9 };
const FORCE: Colour = Colour { r: 0.85, g: 0.3, b: 0.2, a: 1.0 };
