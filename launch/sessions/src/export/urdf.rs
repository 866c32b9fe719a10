//! A robot as URDF.

use super::robot::{ExportBody, ExportRobot, identifier, joint_type, numbers};
use messages::robot::{Joint, table_1};
use messages::scene::{Base, Scene};
use std::path::Path;

/// Position limits of all joints [rad or m], and velocity limits [rad/s or m/s]. URDF requires limits, but this robot has none, so they
/// are far outside its range.
const UNLIMITED_POSITION: f64 = 100.0;
const UNLIMITED_VELOCITY: f64 = 1000.0;

/// The whole file. A robot without a name gets that of its scene, which is a built-in name or a path; the robot of Table 1 is `biped`.
pub fn text(scene: &Scene, scene_name: &str, robot: &ExportRobot) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<!-- Made by `biped export urdf`. Frames are parallel at zero angles: x forward, y \
         left, z up. -->\n",
    );
    let stem = Path::new(scene_name).file_stem().unwrap_or_default().to_string_lossy();
    let own = if scene.bodies == table_1() { "biped" } else { &stem };
    let name = identifier(scene.robot.as_deref().unwrap_or(own));
    out += &format!("<robot name=\"{name}\" xmlns:drake=\"http://drake.mit.edu\">\n");
    let limit = scene.plant.torque_limit;
    for body in &robot.bodies {
        add_link(&mut out, body);
    }
    if scene.plant.base == Base::Fixed {
        let position = numbers(robot.model.mount_position.iter().copied());
        let rotation = numbers(scene.initial.orientation_deg.map(f64::to_radians));
        out += &format!(
            "  <link name=\"world\"/>\n  <joint name=\"mount\" type=\"fixed\">\n    <parent link=\"world\"/>\n    <child \
             link=\"{}\"/>\n    <origin xyz=\"{position}\" rpy=\"{rotation}\"/>\n  </joint>\n",
            robot.bodies[robot.base].name
        );
    }
    for (body, joint) in robot.joints() {
        add_joint(&mut out, robot, body, joint, limit, joint.damping + scene.plant.joint_damping);
    }
    for (body, _) in robot.joints() {
        let name = body.joint_name();
        out += &format!(
            "  <transmission name=\"{name}_drive\">\n    <type>transmission_interface/SimpleTransmission</type>\n    <joint \
             name=\"{name}\"/>\n    <actuator name=\"{name}_motor\">\n      <drake:rotor_inertia value=\"{}\"/>\n      \
             <drake:gear_ratio value=\"1\"/>\n    </actuator>\n  </transmission>\n",
            scene.plant.drive_inertia
        );
    }
    out + "</robot>\n"
}

fn add_link(out: &mut String, body: &ExportBody) {
    let i = &body.inertia;
    let (com, center, size) = (numbers(body.com.iter().copied()), numbers(body.box_center), numbers(body.size));
    *out += &format!(
        "  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{com}\"/>\n      <mass value=\"{}\"/>\n      <inertia \
         ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>\n    </inertial>\n    <visual>\n      \
         <origin xyz=\"{center}\"/>\n      <geometry><box size=\"{size}\"/></geometry>\n    </visual>\n",
        body.name,
        body.mass,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)],
    );
    for sphere in &body.spheres {
        *out += &format!(
            "    <collision>\n      <origin xyz=\"{}\"/>\n      <geometry><sphere radius=\"{}\"/></geometry>\n    \
             </collision>\n",
            numbers(sphere.at),
            sphere.radius
        );
    }
    *out += "  </link>\n";
}

fn add_joint(out: &mut String, robot: &ExportRobot, body: &ExportBody, joint: &Joint, limit: f64, damping: f64) {
    let parent = body.parent.map_or("", |parent| &robot.bodies[parent].name);
    *out += &format!(
        "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{parent}\"/>\n    <child link=\"{}\"/>\n    <origin \
         xyz=\"{}\"/>\n    <axis xyz=\"{}\"/>\n    <limit lower=\"-{UNLIMITED_POSITION}\" upper=\"{UNLIMITED_POSITION}\" effort=\"{limit}\" \
         velocity=\"{UNLIMITED_VELOCITY}\"/>\n    <dynamics damping=\"{damping}\"/>\n  </joint>\n",
        body.joint_name(),
        joint_type(joint, "revolute", "prismatic"),
        body.name,
        numbers(joint.at),
        numbers(joint.axis),
    );
}
