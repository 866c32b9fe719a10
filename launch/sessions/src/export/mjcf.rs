//! A robot and its ground as MJCF.

use super::robot::{ExportBody, ExportRobot, joint_type, numbers};
use messages::scene::{Base, Scene};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use plant::PlantError;
use plant::model::Model;
use plant::state::State;

/// The whole file.
///
/// # Errors
/// If the initial state is invalid.
pub fn text(scene: &Scene, robot: &ExportRobot) -> Result<String, PlantError> {
    let plant = &scene.plant;
    let mut out = format!(
        "<mujoco model=\"biped\">\n  <!-- Made by `biped export mjcf`. Frames are parallel at zero angles: x forward, y \
         left, z up; motors and sensors are in wire order. -->\n  <compiler angle=\"radian\" autolimits=\"true\"/>\n  \
         <option gravity=\"{}\" timestep=\"{}\"/>\n  <default>\n    <geom friction=\"{} 0 0\" condim=\"3\" contype=\"0\" \
         conaffinity=\"0\"/>\n  </default>\n  <worldbody>\n    <geom name=\"ground\" type=\"plane\" size=\"0 0 1\" \
         contype=\"2\" conaffinity=\"1\"/>\n",
        numbers(robot.model.gravity.iter().copied()),
        plant.dt,
        plant.friction,
    );
    add_body(&mut out, scene, robot, robot.base, 2);
    out += "  </worldbody>\n  <actuator>\n";
    for (body, _) in robot.joints() {
        let joint = body.joint_name();
        let limit = plant.torque_limit;
        out += &format!("    <motor name=\"{}_motor\" joint=\"{joint}\" ctrlrange=\"-{limit} {limit}\"/>\n", body.name);
    }
    out += "  </actuator>\n  <sensor>\n";
    for (body, _) in robot.joints() {
        out += &format!("    <jointpos name=\"{}_encoder\" joint=\"{}\"/>\n", body.name, body.joint_name());
    }
    out += "  </sensor>\n  <keyframe>\n";
    let (qpos, qvel) = initial_state(scene)?;
    out += &format!("    <key name=\"start\" qpos=\"{}\" qvel=\"{}\"/>\n", numbers(qpos), numbers(qvel));
    Ok(out + "  </keyframe>\n</mujoco>\n")
}

/// The initial state in MuJoCo's coordinates: the angular velocity of a free base is in the body frame, and joints are in depth-first
/// order.
fn initial_state(scene: &Scene) -> Result<(Vec<f64>, Vec<f64>), PlantError> {
    let mut scene = scene.clone();
    if scene.plant.base == Base::Virtual {
        scene.plant.base = Base::Quaternion;
    }
    let model = Model::new(&scene)?;
    let State { x, mut xdot } = State::initial(&model, &scene.initial)?.in_scene_frame(&model);
    if scene.plant.base == Base::Quaternion {
        let rotation = UnitQuaternion::new_normalize(Quaternion::new(x[3], x[4], x[5], x[6]));
        let body_rate = rotation.inverse_transform_vector(&Vector3::new(xdot[3], xdot[4], xdot[5]));
        xdot[3..6].copy_from_slice(body_rate.as_slice());
    }
    Ok((x, xdot))
}

/// Writes a body and, inside it, its children.
fn add_body(out: &mut String, scene: &Scene, robot: &ExportRobot, index: usize, depth: usize) {
    let body = &robot.bodies[index];
    let indent = "  ".repeat(depth);
    let pose = match &body.joint {
        Some(joint) => format!("pos=\"{}\"", numbers(joint.at)),
        None => base_pose(scene, robot),
    };
    *out += &format!("{indent}<body name=\"{}\" {pose}>\n", body.name);
    for line in joints(scene, body).into_iter().chain([inertial(body)]).chain(shapes(body)) {
        *out += &format!("{indent}  {line}\n");
    }
    for child in robot.children(index) {
        add_body(out, scene, robot, child, depth + 1);
    }
    *out += &format!("{indent}</body>\n");
}

/// The pose of the base at zero coordinates.
fn base_pose(scene: &Scene, robot: &ExportRobot) -> String {
    let model = &robot.model;
    let rotation = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(model.mount_rotation));
    let quaternion = numbers([rotation.w, rotation.i, rotation.j, rotation.k]);
    match scene.plant.base {
        Base::Fixed => format!("pos=\"{}\" quat=\"{quaternion}\"", numbers(model.mount_position.iter().copied())),
        Base::Planar => format!("pos=\"0 {} 0\"", model.mount_position.y + model.base_frame.y),
        Base::Virtual | Base::Quaternion => String::new(), // it is in the keyframe
    }
}

/// The joint of a body, or the joints of the base.
fn joints(scene: &Scene, body: &ExportBody) -> Vec<String> {
    let plant = &scene.plant;
    let Some(joint) = &body.joint else {
        let slide = |name, axis| format!("<joint name=\"{name}\" type=\"slide\" axis=\"{axis}\"/>");
        return match plant.base {
            Base::Fixed => vec![],
            Base::Planar => vec![
                slide("x", "1 0 0"),
                slide("z", "0 0 1"),
                "<joint name=\"pitch\" type=\"hinge\" axis=\"0 1 0\"/>".into(),
            ],
            Base::Virtual | Base::Quaternion => vec!["<freejoint name=\"base\"/>".into()],
        };
    };
    let mut spring = String::new();
    if joint.stiffness != 0.0 {
        spring = format!(" stiffness=\"{}\" springref=\"{}\"", joint.stiffness, joint.rest);
    }
    vec![format!(
        "<joint name=\"{}\" type=\"{}\" axis=\"{}\" armature=\"{}\" damping=\"{}\"{spring}/>",
        body.joint_name(),
        joint_type(joint, "hinge", "slide"),
        numbers(joint.axis),
        plant.drive_inertia,
        plant.joint_damping + joint.damping,
    )]
}

fn inertial(body: &ExportBody) -> String {
    let i = &body.inertia;
    let products = [i[(0, 1)], i[(0, 2)], i[(1, 2)]];
    let moments = match products == [0.0; 3] {
        true => format!("diaginertia=\"{}\"", numbers([i[(0, 0)], i[(1, 1)], i[(2, 2)]])),
        false => format!("fullinertia=\"{}\"", numbers([i[(0, 0)], i[(1, 1)], i[(2, 2)]].into_iter().chain(products))),
    };
    format!("<inertial pos=\"{}\" mass=\"{}\" {moments}/>", numbers(body.com.iter().copied()), body.mass)
}

/// The visual box and the contact spheres of a body.
fn shapes(body: &ExportBody) -> Vec<String> {
    let half = body.size.map(|side| 0.5 * side);
    let mut shapes = vec![];
    if half.iter().all(|&side| side > 0.0) {
        shapes.push(format!(
            "<geom type=\"box\" pos=\"{}\" size=\"{}\" group=\"2\"/>",
            numbers(body.box_center),
            numbers(half)
        ));
    }
    for (k, sphere) in body.spheres.iter().enumerate() {
        let [x, y, z] = sphere.at;
        shapes.push(format!(
            "<geom type=\"sphere\" pos=\"{}\" size=\"{}\" contype=\"1\" conaffinity=\"2\" group=\"3\"/>",
            numbers(sphere.at),
            sphere.radius
        ));
        if k < body.points {
            shapes.push(format!("<site name=\"{}_{k}\" pos=\"{}\"/>", body.name, numbers([x, y, z - sphere.radius])));
        }
    }
    shapes
}
