//! A robot as TOML, which `--robot` reads: to be edited into another one.

use messages::robot::{Body, Joint, canonical_biped};
use messages::scene::Scene;
use toml::{Table, Value};

/// What to know before editing.
const HEAD: &str = "\
# A robot, as `biped export toml` prints it. Frames are parallel at zero angles: x forward, y left, z up. A body's frame sits in
# the joint that carries it; `at` is that joint in the frame of its parent. Lengths in m, masses in kg, inertias in kg·m².
";
/// And of those that can walk.
const BIPED: &str = "\
#
# Edit it, save it as my.toml, and: biped run walk --robot my.toml
#
# A trunk and two legs of four joints: hip, knee and ankle pitch, ankle roll. The gait, the servos' gains and the posture at the
# start follow from the robot by dynamic similarity; `--set` changes any of them.
";
const HALF: &str = "
# The right leg is the mirror image of the left one; written out, it must be that.
";
/// Keys of a body in the order in which people think of them, and what is not plain by itself.
const KEYS: [(&str, &str); 9] = [
    ("name", ""),
    ("mass", ""),
    ("size", "# depth, width and height of the box that is drawn and, without `inertia`, uniformly filled\n"),
    ("com", "# centre of mass, also the centre of the box\n"),
    ("inertia", "# principal moments about the centre of mass\n"),
    ("joint", "# to the parent\n"),
    ("contacts", "# corners of the sole\n"),
    ("spheres", "# balls that may touch the ground\n"),
    ("tiles", "# where there is ground for this body\n"),
];
/// Keys of a joint, likewise.
const JOINT: [&str; 7] = ["parent", "kind", "axis", "at", "stiffness", "damping", "rest"];

/// The whole file; of a biped whose legs are mirror images one leg is enough.
pub fn text(scene: &Scene) -> String {
    let plant = &scene.plant;
    let half = scene.bodies.get(..5).filter(|half| canonical_biped(half).as_ref() == Ok(&scene.bodies));
    let is_biped = canonical_biped(&scene.bodies).is_ok();
    let mut out = [HEAD, if is_biped { BIPED } else { "" }].concat();
    out += &format!("\nname = {}\n\n", Value::from(scene.robot_name()));
    out += &format!(
        "[drives]\n# reflected at each joint, J_r [kg·m²]; viscous, D [N·m·s/rad]; [N·m]; counts per turn are 2 to this power\n\
         inertia = {}\ndamping = {}\ntorque_limit = {}\nencoder_bits = {}\n",
        Value::from(plant.drive_inertia),
        Value::from(plant.joint_damping),
        Value::from(plant.torque_limit),
        plant.encoder_bits,
    );
    let mut told = vec![];
    for written in half.unwrap_or(&scene.bodies) {
        out += "\n[[bodies]]\n";
        let table = table(written);
        for (key, meaning) in KEYS.iter().filter(|(key, _)| table.contains_key(*key)) {
            if !told.contains(key) {
                out += meaning;
                told.push(key);
            }
            out += &match key {
                &"joint" => format!("joint = {{ {} }}\n", joint(&table[*key])),
                key => format!("{key} = {}\n", table[*key]),
            };
        }
    }
    if half.is_some() { out + HALF } else { out }
}

/// A body without what goes without saying.
fn table(body: &Body) -> Table {
    let mut table = Table::try_from(body).unwrap_or_default();
    if body.com == [0.0; 3] {
        table.remove("com");
    }
    table
}

/// The inside of a joint's table, likewise.
fn joint(joint: &Value) -> String {
    let plain = Table::try_from(Joint::default()).unwrap_or_default();
    let said = JOINT
        .iter()
        .filter_map(|key| Some((key, joint.get(key)?)))
        .filter(|(key, value)| plain.get(**key) != Some(value));
    said.map(|(key, value)| format!("{key} = {value}")).collect::<Vec<_>>().join(", ")
}
