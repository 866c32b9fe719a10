//! A robot and its ground as MJCF.

use super::robot::{Part, Robot, kind, numbers};
use messages::scene::{Base, Scene};
use nalgebra::{Quaternion, Rotation3, UnitQuaternion, Vector3};
use plant::PlantError;
use plant::model::Model;
use plant::state::State;

/// The whole file.
///
/// # Errors
/// An initial state that is refused.
pub fn text(scene: &Scene, robot: &Robot) -> Result<String, PlantError> {
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
    body(&mut out, scene, robot, robot.base, 2);
    out += "  </worldbody>\n  <actuator>\n";
    for (part, _) in robot.joints() {
        let joint = part.joint_name();
        let limit = plant.torque_limit;
        out += &format!("    <motor name=\"{}_motor\" joint=\"{joint}\" ctrlrange=\"-{limit} {limit}\"/>\n", part.name);
    }
    out += "  </actuator>\n  <sensor>\n";
    for (part, _) in robot.joints() {
        out += &format!("    <jointpos name=\"{}_encoder\" joint=\"{}\"/>\n", part.name, part.joint_name());
    }
    out += "  </sensor>\n  <keyframe>\n";
    let (qpos, qvel) = start(scene)?;
    out += &format!("    <key name=\"start\" qpos=\"{}\" qvel=\"{}\"/>\n", numbers(qpos), numbers(qvel));
    Ok(out + "  </keyframe>\n</mujoco>\n")
}

/// The scene's initial state as MuJoCo counts it: a free base turns in its own axes, and joints come depth first.
fn start(scene: &Scene) -> Result<(Vec<f64>, Vec<f64>), PlantError> {
    let mut scene = scene.clone();
    if scene.plant.base == Base::Virtual {
        scene.plant.base = Base::Quaternion;
    }
    let State { x, mut xdot } = State::initial(&Model::new(&scene)?, &scene.initial)?;
    if scene.plant.base == Base::Quaternion {
        let turn = UnitQuaternion::new_normalize(Quaternion::new(x[3], x[4], x[5], x[6]));
        let spin = turn.inverse_transform_vector(&Vector3::new(xdot[3], xdot[4], xdot[5]));
        xdot[3..6].copy_from_slice(spin.as_slice());
    }
    Ok((x, xdot))
}

/// A body with all that hangs from it.
fn body(out: &mut String, scene: &Scene, robot: &Robot, index: usize, depth: usize) {
    let part = &robot.parts[index];
    let indent = "  ".repeat(depth);
    let place = match &part.joint {
        Some(joint) => format!("pos=\"{}\"", numbers(joint.at)),
        None => mount(scene, robot),
    };
    *out += &format!("{indent}<body name=\"{}\" {place}>\n", part.name);
    for line in joints(scene, part).into_iter().chain([inertial(part)]).chain(shapes(part)) {
        *out += &format!("{indent}  {line}\n");
    }
    for child in robot.children(index) {
        body(out, scene, robot, child, depth + 1);
    }
    *out += &format!("{indent}</body>\n");
}

/// Where the base is before its own joints move it.
fn mount(scene: &Scene, robot: &Robot) -> String {
    let model = &robot.model;
    let turn = UnitQuaternion::from_rotation_matrix(&Rotation3::from_matrix_unchecked(model.mount_rotation));
    let quaternion = numbers([turn.w, turn.i, turn.j, turn.k]);
    match scene.plant.base {
        Base::Fixed => format!("pos=\"{}\" quat=\"{quaternion}\"", numbers(model.mount_position.iter().copied())),
        Base::Planar => format!("pos=\"{}\"", numbers(model.mount_position.iter().copied())),
        Base::Virtual | Base::Quaternion => String::new(), // the keyframe has it
    }
}

fn joints(scene: &Scene, part: &Part) -> Vec<String> {
    let plant = &scene.plant;
    let Some(joint) = &part.joint else {
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
        part.joint_name(),
        kind(joint, "hinge", "slide"),
        numbers(joint.axis),
        plant.drive_inertia,
        plant.joint_damping + joint.damping,
    )]
}

fn inertial(part: &Part) -> String {
    let i = &part.inertia;
    let products = [i[(0, 1)], i[(0, 2)], i[(1, 2)]];
    let moments = match products == [0.0; 3] {
        true => format!("diaginertia=\"{}\"", numbers([i[(0, 0)], i[(1, 1)], i[(2, 2)]])),
        false => format!("fullinertia=\"{}\"", numbers([i[(0, 0)], i[(1, 1)], i[(2, 2)]].into_iter().chain(products))),
    };
    format!("<inertial pos=\"{}\" mass=\"{}\" {moments}/>", numbers(part.com.iter().copied()), part.mass)
}

/// What is drawn, and what touches the ground.
fn shapes(part: &Part) -> Vec<String> {
    let half = part.size.map(|side| 0.5 * side);
    let mut shapes = vec![];
    if half.iter().all(|&side| side > 0.0) {
        shapes.push(format!(
            "<geom type=\"box\" pos=\"{}\" size=\"{}\" group=\"2\"/>",
            numbers(part.middle),
            numbers(half)
        ));
    }
    for (k, ball) in part.touching.iter().enumerate() {
        let [x, y, z] = ball.at;
        shapes.push(format!(
            "<geom type=\"sphere\" pos=\"{}\" size=\"{}\" contype=\"1\" conaffinity=\"2\" group=\"3\"/>",
            numbers(ball.at),
            ball.radius
        ));
        if ball.radius == super::robot::POINT {
            shapes.push(format!("<site name=\"{}_{k}\" pos=\"{}\"/>", part.name, numbers([x, y, z - ball.radius])));
        }
    }
    shapes
}
