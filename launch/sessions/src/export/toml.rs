//! A robot as TOML, for editing and for `--robot`.

use messages::robot::{Body, Joint, canonical_biped};
use messages::scene::Scene;
use toml::{Table, Value};

/// Comment at the start of every file.
const HEADER: &str = "\
# A robot, as `biped export toml` prints it. Frames are parallel at zero angles: x forward, y left, z up. The origin of a body's
# frame is the joint to its parent; `at` is the position of that joint in the parent's frame. Lengths in m, masses in kg, inertias in kg·m².
";
/// Further comment for a robot that can walk.
const WALKER_COMMENT: &str = "\
#
# Edit it, save it as my.toml, and: biped run walk --robot my.toml
#
# A trunk and two legs of four joints: hip, knee and ankle pitch, ankle roll. The gait, the servo gains and the initial posture are
# scaled to the robot by dynamic similarity; `--set` changes any of them.
";
/// The same for a robot that is no such biped: the file is a scene, because only a scene may have any bodies.
const SCENE_COMMENT: &str = "\
#
# This is a scene: edit it, save it as my.toml, and: biped run my.toml
# The rest of the scene from which it comes, such as its initial state, is in DIR/scene.toml of `biped run --out DIR`.
";
/// Comment at the end of a file with one leg.
const MIRROR_COMMENT: &str = "
# The right leg is the mirror image of the left one. If it is written too, it has to be exactly that.
";
/// Keys of a body in output order, with comments.
const BODY_KEYS: [(&str, &str); 9] = [
    ("name", ""),
    ("mass", ""),
    (
        "size",
        "# depth, width and height of the visual box; without `inertia`, it is also a solid box of uniform density\n",
    ),
    ("com", "# centre of mass, and centre of the box\n"),
    ("inertia", "# principal moments about the centre of mass\n"),
    ("joint", "# to the parent\n"),
    ("contacts", "# corners of the sole\n"),
    ("spheres", "# spheres that may touch the ground\n"),
    ("tiles", "# the areas where there is ground for this body\n"),
];
/// Keys of a joint in output order, and whether a file may leave it out if it has its default.
const JOINT_KEYS: [(&str, bool); 7] = [
    ("parent", false),
    ("kind", true),
    ("axis", false),
    ("at", false),
    ("stiffness", true),
    ("damping", true),
    ("rest", true),
];

/// Bodies of a biped with one leg: the trunk and the four of a leg.
const HALF_BODIES: usize = 5;

/// The whole file. A biped whose legs are mirror images is written with the left leg only.
pub fn text(scene: &Scene) -> String {
    let plant = &scene.plant;
    let half = scene.bodies.get(..HALF_BODIES).filter(|half| canonical_biped(half).as_ref() == Ok(&scene.bodies));
    let is_biped = canonical_biped(&scene.bodies).is_ok();
    let mut out = [HEADER, if is_biped { WALKER_COMMENT } else { SCENE_COMMENT }].concat();
    let (key, table, drive) = match is_biped {
        true => ("name", "drives", ["inertia", "damping", "torque_limit", "encoder_bits"]),
        false => ("robot", "plant", ["drive_inertia", "joint_damping", "torque_limit", "encoder_bits"]),
    };
    if is_biped || scene.robot.is_some() {
        out += &format!("\n{key} = {}\n", Value::from(scene.robot_name()));
    }
    out += &format!(
        "\n[{table}]\n# rotor inertia reflected to the joint, J_r [kg·m²]; viscous damping, D [N·m·s/rad]; torque limit [N·m];\n\
         # encoder counts per turn, as a power of 2\n"
    );
    let values = [plant.drive_inertia, plant.joint_damping, plant.torque_limit].map(Value::from);
    for (key, value) in drive.into_iter().zip(values.into_iter().chain([Value::from(plant.encoder_bits)])) {
        out += &format!("{key} = {value}\n");
    }
    if !is_biped {
        out += &Value::try_from(plant.base).map_or(String::new(), |base| format!("base = {base}\n"));
    }
    let mut explained = vec![];
    for body in half.unwrap_or(&scene.bodies) {
        out += "\n[[bodies]]\n";
        let table = body_table(body);
        for (key, comment) in BODY_KEYS.iter().filter(|(key, _)| table.contains_key(*key)) {
            if !explained.contains(key) {
                out += comment;
                explained.push(key);
            }
            out += &match key {
                &"joint" => format!("joint = {{ {} }}\n", joint_fields(&table[*key])),
                key => format!("{key} = {}\n", table[*key]),
            };
        }
    }
    if half.is_some() { out + MIRROR_COMMENT } else { out }
}

/// A body as a table, without a centre of mass at the origin.
fn body_table(body: &Body) -> Table {
    let mut table = Table::try_from(body).unwrap_or_default();
    if body.com == [0.0; 3] {
        table.remove("com");
    }
    table
}

/// The fields of a joint as an inline table, without those that have their default.
fn joint_fields(joint: &Value) -> String {
    let default = Table::try_from(Joint::default()).unwrap_or_default();
    let fields = JOINT_KEYS
        .iter()
        .filter_map(|(key, may_be_absent)| Some((key, joint.get(key)?, may_be_absent)))
        .filter(|(key, value, may_be_absent)| !**may_be_absent || default.get(**key) != Some(value));
    fields.map(|(key, value, _)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}
