//! A robot as URDF.

use super::robot::{Part, Robot, kind, numbers, plain};
use messages::robot::Joint;
use messages::scene::{Base, Scene};

/// The whole file.
pub fn text(scene: &Scene, robot: &Robot) -> String {
    let mut out = String::from(
        "<?xml version=\"1.0\"?>\n<!-- Made by `biped export urdf`. Frames are parallel at zero angles: x forward, y \
         left, z up. -->\n",
    );
    let name = plain(scene.robot.as_deref().unwrap_or("biped"));
    out += &format!("<robot name=\"{name}\" xmlns:drake=\"http://drake.mit.edu\">\n");
    let limit = scene.plant.torque_limit;
    for part in &robot.parts {
        link(&mut out, part);
    }
    if scene.plant.base == Base::Fixed {
        let position = numbers(robot.model.mount_position.iter().copied());
        let turn = numbers(scene.initial.orientation_deg.map(f64::to_radians));
        out += &format!(
            "  <link name=\"world\"/>\n  <joint name=\"mount\" type=\"fixed\">\n    <parent link=\"world\"/>\n    <child \
             link=\"{}\"/>\n    <origin xyz=\"{position}\" rpy=\"{turn}\"/>\n  </joint>\n",
            robot.parts[robot.base].name
        );
    }
    for (part, own) in robot.joints() {
        joint(&mut out, robot, part, own, limit, own.damping + scene.plant.joint_damping);
    }
    for (part, _) in robot.joints() {
        let name = part.joint_name();
        out += &format!(
            "  <transmission name=\"{name}_drive\">\n    <type>transmission_interface/SimpleTransmission</type>\n    <joint \
             name=\"{name}\"/>\n    <actuator name=\"{name}_motor\">\n      <drake:rotor_inertia value=\"{}\"/>\n      \
             <drake:gear_ratio value=\"1\"/>\n    </actuator>\n  </transmission>\n",
            scene.plant.drive_inertia
        );
    }
    out + "</robot>\n"
}

fn link(out: &mut String, part: &Part) {
    let i = &part.inertia;
    let (com, middle, size) = (numbers(part.com.iter().copied()), numbers(part.middle), numbers(part.size));
    *out += &format!(
        "  <link name=\"{}\">\n    <inertial>\n      <origin xyz=\"{com}\"/>\n      <mass value=\"{}\"/>\n      <inertia \
         ixx=\"{}\" ixy=\"{}\" ixz=\"{}\" iyy=\"{}\" iyz=\"{}\" izz=\"{}\"/>\n    </inertial>\n    <visual>\n      \
         <origin xyz=\"{middle}\"/>\n      <geometry><box size=\"{size}\"/></geometry>\n    </visual>\n",
        part.name,
        part.mass,
        i[(0, 0)],
        i[(0, 1)],
        i[(0, 2)],
        i[(1, 1)],
        i[(1, 2)],
        i[(2, 2)],
    );
    for ball in &part.touching {
        *out += &format!(
            "    <collision>\n      <origin xyz=\"{}\"/>\n      <geometry><sphere radius=\"{}\"/></geometry>\n    \
             </collision>\n",
            numbers(ball.at),
            ball.radius
        );
    }
    *out += "  </link>\n";
}

fn joint(out: &mut String, robot: &Robot, part: &Part, own: &Joint, limit: f64, damping: f64) {
    let parent = part.parent.map_or("", |parent| &robot.parts[parent].name);
    *out += &format!(
        "  <joint name=\"{}\" type=\"{}\">\n    <parent link=\"{parent}\"/>\n    <child link=\"{}\"/>\n    <origin \
         xyz=\"{}\"/>\n    <axis xyz=\"{}\"/>\n    <limit lower=\"-100\" upper=\"100\" effort=\"{limit}\" \
         velocity=\"1000\"/>\n    <dynamics damping=\"{damping}\"/>\n  </joint>\n",
        part.joint_name(),
        kind(own, "revolute", "prismatic"),
        part.name,
        numbers(own.at),
        numbers(own.axis),
    );
}
