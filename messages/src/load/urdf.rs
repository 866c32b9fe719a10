//! Robots as URDF: the files that `biped export urdf` writes, and others of the same form.
//!
//! | in the file | in the robot |
//! |---|---|
//! | `inertial`: mass, `origin`, moments of inertia | the same; products of inertia must be 0 |
//! | box of the first `visual` | size of the box that is drawn |
//! | `collision`: sphere | ball; contact point if its radius is 1 mm |
//! | `collision`: box | contact points at its bottom corners |
//! | `effort`, `drake:rotor_inertia` times `drake:gear_ratio`², `damping` | drives |
//! | `fixed` joints of links without mass | nothing |
//! | `calibration`, and elements of other programs such as `gazebo` | nothing: they describe no part of the robot |
//!
//! Properties of joints that this simulator does not model are refused: [`unsupported`]. So are parts that may occur once and occur
//! twice: [`repeated`].

mod repeated;
mod unsupported;
mod xml;

use crate::robot::{Body, DriveParameters, Joint, JointKind, Robot, Sphere};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;
use xml::{Parsed, attribute, child, children, linked, number, optional, vector};

/// Values up to this are rounding of the program that wrote the file and count as 0: products of inertia over the largest moment [-],
/// angles [rad].
const ROUNDING: f64 = 1e-9;
/// Size of the drawn box of a body for which the file draws none [m]. It affects no motion: the moments of inertia are given.
const UNDRAWN_SIZE: [f64; 3] = [0.05; 3];
/// Heights of contact points are rounded to this grid: nanometres [1/m].
const GRID: f64 = 1e9;
/// Radius of the balls that represent contact points [m].
const POINT_RADIUS: f64 = 1e-3;

/// The robot of a URDF file, not yet in canonical order and not yet checked.
pub(super) fn parse(text: &str) -> Parsed<Robot> {
    let document = Document::parse(text).map_err(|error| format!("the file is not XML: {error}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(format!("the root element of a URDF file is `robot`, not `{}`", root.tag_name().name()));
    }
    repeated::refuse(root)?;
    let joints: Vec<Node> = children(root, "joint").collect();
    unsupported::refuse(&joints)?;
    let mut bodies = vec![];
    for link in children(root, "link") {
        let name = attribute(link, "name")?;
        let carrier = joints.iter().find(|joint| linked(**joint, "child") == Some(name));
        let moved = carrier.copied().filter(|joint| joint.attribute("type") != Some("fixed"));
        if moved.is_none() && child(link, "inertial").is_none() {
            continue; // a link without mass: a frame, or the world
        }
        if let Some(weld) = carrier.filter(|weld| moved.is_none() && !massless(root, linked(**weld, "parent"))) {
            return Err(format!(
                "joint `{}` fixes `{name}` to a link with mass: combine the two links into one",
                attribute(*weld, "name")?
            ));
        }
        bodies.push(body(link, name, moved)?);
    }
    let moving = || joints.iter().copied().filter(|joint| joint.attribute("type") != Some("fixed"));
    let dampings: Vec<f64> = moving()
        .map(|joint| child(joint, "dynamics").map_or(Ok(0.0), |node| optional(node, "damping", 0.0)))
        .collect::<Parsed<_>>()?;
    let damping = common(&dampings);
    if damping.is_none() {
        // the joints differ, so each keeps its own damping
        for (joint, own) in moving().zip(&dampings) {
            let name = linked(joint, "child");
            bodies
                .iter_mut()
                .filter(|body| Some(&*body.name) == name)
                .flat_map(|body| &mut body.joint)
                .for_each(|joint| joint.damping = *own);
        }
    }
    let drives = DriveParameters {
        inertia: require_common("rotor_inertia", &rotors(root)?, moving().count())?,
        damping: damping.or(Some(0.0)),
        torque_limit: require_common("effort", &efforts(moving())?, moving().count())?,
        encoder_bits: None,
    };
    let name = root.attribute("name").unwrap_or_default();
    Ok(Robot { name: name.into(), drives, bodies })
}

/// The sentence about a joint that fixes the robot to a link named `world`, if there is one. Other programs then hold the robot, which moves
/// freely here unless `plant.base` is fixed.
pub(super) fn mount(text: &str) -> Option<String> {
    let document = Document::parse(text).ok()?;
    let is_mount = |joint: &Node| joint.attribute("type") == Some("fixed") && linked(*joint, "parent") == Some("world");
    let joint = children(document.root_element(), "joint").find(is_mount)?;
    let (name, link) = (joint.attribute("name")?, linked(joint, "child")?);
    let free = "the robot is free to move: plant.base = \"fixed\" fixes it";
    Some(format!("joint `{name}` fixes `{link}` to the link `world`, but {free}"))
}

fn body(link: Node, name: &str, joint: Option<Node>) -> Parsed<Body> {
    let inertial = child(link, "inertial")
        .ok_or(format!("`{name}` has no inertial: every link that moves needs mass and inertia"))?;
    let part = |tag| child(inertial, tag).ok_or(format!("the inertial of `{name}` has no {tag}"));
    let mass = number(part("mass")?, "value")?;
    let tensor = part("inertia")?;
    let moments = [number(tensor, "ixx")?, number(tensor, "iyy")?, number(tensor, "izz")?];
    let rounding = ROUNDING * moments.into_iter().fold(0.0, f64::max);
    for product in ["ixy", "ixz", "iyz"] {
        let value = optional(tensor, product, 0.0)?;
        if value.abs() > rounding {
            return Err(format!("{product} of `{name}` is {value}, not 0: the principal axes must be x, y and z"));
        }
    }
    let com = origin(inertial, name)?;
    let drawn = children(link, "visual").find_map(|visual| child(child(visual, "geometry")?, "box"));
    let size = drawn.map_or(Ok(UNDRAWN_SIZE), |shape| vector(shape, "size"))?;
    let mut body = Body { name: name.into(), mass, size, com, ..Body::default() };
    if body.moments() != moments {
        body.inertia = Some(moments);
    }
    for collision in children(link, "collision") {
        add_contacts(&mut body, collision)?;
    }
    body.joint = joint.map(|node| joint_of(node)).transpose()?;
    Ok(body)
}

/// Adds the contact points and balls of a collision shape. Other shapes would touch the ground somewhere else, so they are refused.
fn add_contacts(body: &mut Body, collision: Node) -> Parsed<()> {
    let at = origin(collision, &body.name)?;
    for shape in children(collision, "geometry").flat_map(|geometry| geometry.children()).filter(Node::is_element) {
        match shape.tag_name().name() {
            "sphere" => match number(shape, "radius")? {
                POINT_RADIUS => body.contacts.push([at[0], at[1], point_height(at[2])]),
                radius => body.spheres.push(Sphere { at, radius }),
            },
            "box" => {
                let half = vector(shape, "size")?.map(|side| 0.5 * side);
                for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    body.contacts.push([at[0] + x * half[0], at[1] + y * half[1], at[2] - half[2]]);
                }
            }
            other => {
                return Err(format!(
                    "the collision of `{}` has a {other}, but only spheres and boxes touch the ground here: use them, or remove it",
                    body.name
                ));
            }
        }
    }
    Ok(())
}

/// Height of a contact point below the centre of its ball. It is rounded to nanometres if that gives the same centre, so that an
/// exported robot is read back exactly.
fn point_height(height: f64) -> f64 {
    let short = ((height - POINT_RADIUS) * GRID).round() / GRID;
    if short + POINT_RADIUS == height { short } else { height - POINT_RADIUS }
}

fn joint_of(node: Node) -> Parsed<Joint> {
    let name = attribute(node, "name")?;
    let kind = match attribute(node, "type")? {
        "revolute" | "continuous" => JointKind::Revolute,
        "prismatic" => JointKind::Prismatic,
        other => {
            return Err(format!(
                "joint `{name}` has the type {other}, but it must be revolute, continuous or prismatic"
            ));
        }
    };
    let axis = child(node, "axis").map_or(Ok([1.0, 0.0, 0.0]), |axis| vector(axis, "xyz"))?;
    let length = axis.iter().map(|c| c * c).sum::<f64>().sqrt();
    if length == 0.0 {
        return Err(format!("the axis of joint `{name}` is 0 0 0, but it needs a direction"));
    }
    let parent = linked(node, "parent").ok_or(format!("joint `{name}` has no parent"))?;
    Ok(Joint {
        parent: parent.into(),
        kind,
        axis: axis.map(|c| c / length),
        at: origin(node, name)?,
        ..Joint::default()
    })
}

/// Reflected inertia of each drive for which the file gives one: rotor inertia times the square of the gear ratio.
fn rotors(root: Node) -> Parsed<Vec<f64>> {
    let actuators = children(root, "transmission").flat_map(|transmission| children(transmission, "actuator"));
    let reflected = actuators.filter_map(|actuator| {
        let rotor = child(actuator, "rotor_inertia")?;
        let ratio = child(actuator, "gear_ratio").map_or(Ok(1.0), |gear| number(gear, "value"));
        Some(number(rotor, "value").and_then(|rotor| Ok(rotor * ratio?.powi(2))))
    });
    reflected.collect()
}

fn efforts<'a>(joints: impl Iterator<Item = Node<'a, 'a>>) -> Parsed<Vec<f64>> {
    joints.filter_map(|joint| child(joint, "limit")).map(|limit| number(limit, "effort")).collect()
}

/// The common value, if all values are equal.
fn common(values: &[f64]) -> Option<f64> {
    values.first().copied().filter(|first| values.iter().all(|value| value == first))
}

/// The common value of a quantity that must be equal for all drives, or absent from all.
fn require_common(what: &str, values: &[f64], drives: usize) -> Parsed<Option<f64>> {
    let kinds: BTreeSet<String> = values.iter().map(f64::to_string).collect();
    match kinds.len() {
        0 => Ok(None),
        1 if values.len() == drives => Ok(common(values)),
        1 => Err(format!("{what} is given for {} of {drives} joints, but all drives must be equal", values.len())),
        _ => {
            let kinds = kinds.into_iter().collect::<Vec<_>>().join(", ");
            Err(format!("{what} differs between joints ({kinds}), but all drives must be equal"))
        }
    }
}

/// Position of an origin. It must not be rotated, because all frames are parallel at zero angles.
fn origin(node: Node, of: &str) -> Parsed<[f64; 3]> {
    let Some(origin) = child(node, "origin") else { return Ok([0.0; 3]) };
    if origin.attribute("rpy").is_some() && !vector(origin, "rpy")?.iter().all(|angle| angle.abs() <= ROUNDING) {
        return Err(format!("`{of}` has a rotated origin (rpy), but all frames must be parallel at zero angles"));
    }
    origin.attribute("xyz").map_or(Ok([0.0; 3]), |_| vector(origin, "xyz"))
}

fn massless(root: Node, name: Option<&str>) -> bool {
    children(root, "link").any(|link| link.attribute("name") == name && child(link, "inertial").is_none())
}
