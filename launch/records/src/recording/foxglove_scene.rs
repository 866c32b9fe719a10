//! Messages for Foxglove's 3-D panel: a frame per body, boxes fixed to the frames, and an arrow per contact force.

use super::events::FoxgloveTime;
use super::mcap_file::{McapWriter, json_channel, json_message};
use crate::analysis::KinematicTree;
use mcap::McapResult;
use messages::robot::Body;
use messages::scene::Scene;
use messages::wire::Truth;
use nalgebra::{Isometry3, Point3, UnitQuaternion, Vector3};
use schemars::JsonSchema;
use serde::Serialize;

/// Scale of the arrows [m/N]: half the robot's weight is about 0.14 m, a leg's length is 0.4 m.
const METRES_PER_NEWTON: f64 = 2e-3;
/// Diameter of an arrow's shaft, length and diameter of its head [m].
const ARROW_SIZES: [f64; 3] = [0.006, 0.02, 0.014];
/// Name of the world frame.
const WORLD: &str = "world";

/// Writes the robot to its channels.
pub(super) struct FoxgloveScene {
    robot: KinematicTree,
    frames: u16,
    forces: u16,
    boxes: u16,
    has_written_boxes: bool,
}

impl FoxgloveScene {
    /// Creates the channels.
    pub fn new(file: &mut McapWriter, scene: &Scene) -> McapResult<FoxgloveScene> {
        Ok(FoxgloveScene {
            robot: KinematicTree::new(scene),
            frames: json_channel::<FrameTransforms>(file, "/tf", "foxglove.FrameTransforms")?,
            boxes: json_channel::<SceneUpdate>(file, "/robot", "foxglove.SceneUpdate")?,
            forces: json_channel::<SceneUpdate>(file, "/forces", "foxglove.SceneUpdate")?,
            has_written_boxes: false,
        })
    }

    /// The bodies of the robot.
    pub fn bodies(&self) -> &[Body] {
        &self.robot.bodies
    }

    /// Writes the messages of one record.
    pub fn write(&mut self, file: &mut McapWriter, truth: &Truth, time: u64) -> McapResult<()> {
        let timestamp = FoxgloveTime::new(time);
        let states = self.robot.body_states(truth);
        if !std::mem::replace(&mut self.has_written_boxes, true) {
            json_message(file, self.boxes, time, &self.boxes(timestamp))?;
        }
        let transforms = self.robot.bodies.iter().zip(&states).map(|(body, state)| FrameTransform {
            timestamp,
            parent_frame_id: WORLD,
            child_frame_id: body.name.clone(),
            translation: state.pose.translation.vector.into(),
            rotation: UnitQuaternion::from(state.pose.rotation).into(),
        });
        json_message(file, self.frames, time, &FrameTransforms { transforms: transforms.collect() })?;
        let arrows =
            self.robot.contacts.iter().zip(truth.contact_force.chunks(3)).filter_map(|((body, ball), force)| {
                let force = Vector3::from_column_slice(force);
                let point = states[*body].pose * Point3::from(ball.at) - Vector3::z() * ball.radius;
                (force.norm() > 0.0).then(|| Arrow::new(point, force))
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

/// The fields of an entity that we do not use. Readers require them.
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
    /// An entity without primitives that lasts until it is replaced.
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
    fn new(start: Point3<f64>, force: Vector3<f64>) -> Arrow {
        let [shaft_diameter, head_length, head_diameter] = ARROW_SIZES;
        // An arrow points along the x axis of its pose.
        let rotation = UnitQuaternion::rotation_between(&Vector3::x(), &force);
        let rotation =
            rotation.unwrap_or_else(|| UnitQuaternion::from_axis_angle(&Vector3::z_axis(), std::f64::consts::PI));
        Arrow {
            pose: Isometry3::from_parts(start.into(), rotation).into(),
            shaft_length: METRES_PER_NEWTON * force.norm(),
            shaft_diameter,
            head_length,
            head_diameter,
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
    fn from(rotation: UnitQuaternion<f64>) -> FoxgloveQuaternion {
        FoxgloveQuaternion { x: rotation.i, y: rotation.j, z: rotation.k, w: rotation.w }
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
