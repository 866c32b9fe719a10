//! Robots as URDF: what `biped export urdf` writes, and other files of the same shape.
//!
//! | from | becomes |
//! |---|---|
//! | `inertial`: mass, `origin`, moments | the same; products of inertia must be 0 |
//! | box of the first `visual` | size of the drawing |
//! | `collision` spheres; of a box its bottom corners | balls; of 1 mm, and corners: points |
//! | `effort`, `drake:rotor_inertia` times `drake:gear_ratio`², `damping` | drives |
//! | `fixed` joints of links without mass | nothing |
//!
//! What joints here do not have is refused: [`unsupported`].

mod unsupported;

use crate::robot::{Body, Drives, Joint, JointKind, Robot, Sphere};
use roxmltree::{Document, Node};
use std::collections::BTreeSet;

/// Rounding of a program that made the file: products of inertia by the greatest moment, angles in rad, that are as good as 0.
const ROUNDING: f64 = 1e-9;
/// Radius of the balls that stand for points [m].
const POINT: f64 = 1e-3;

type Parsed<T> = Result<T, String>;

/// The robot of a URDF file, neither arranged nor checked.
pub(super) fn parse(text: &str) -> Parsed<Robot> {
    let document = Document::parse(text).map_err(|error| format!("no XML: {error}"))?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(format!("a URDF file is one `robot`, not `{}`", root.tag_name().name()));
    }
    let joints: Vec<Node> = children(root, "joint").collect();
    unsupported::refuse(&joints)?;
    let mut bodies = vec![];
    for link in children(root, "link") {
        let name = attribute(link, "name")?;
        let carrier = joints.iter().find(|joint| linked(**joint, "child") == Some(name));
        let moved = carrier.copied().filter(|joint| joint.attribute("type") != Some("fixed"));
        if moved.is_none() && child(link, "inertial").is_none() {
            continue; // a frame, or the world
        }
        if let Some(weld) = carrier.filter(|weld| moved.is_none() && !massless(root, linked(**weld, "parent"))) {
            return Err(format!(
                "`{name}` is fixed by `{}` to a link with mass: make one link of both",
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
        // each joint keeps its own
        for (joint, own) in moving().zip(&dampings) {
            let name = linked(joint, "child");
            bodies
                .iter_mut()
                .filter(|body| Some(&*body.name) == name)
                .flat_map(|body| &mut body.joint)
                .for_each(|joint| joint.damping = *own);
        }
    }
    let drives = Drives {
        inertia: alike("rotor_inertia", &rotors(root)?)?,
        damping: damping.or(Some(0.0)),
        torque_limit: alike("effort", &efforts(moving())?)?,
        encoder_bits: None,
    };
    let name = root.attribute("name").unwrap_or_default();
    Ok(Robot { name: name.into(), drives, bodies })
}

fn body(link: Node, name: &str, joint: Option<Node>) -> Parsed<Body> {
    let inertial =
        child(link, "inertial").ok_or(format!("`{name}` has no inertial: every link needs mass and inertia"))?;
    let part = |tag| child(inertial, tag).ok_or(format!("the inertial of `{name}` has no {tag}"));
    let mass = number(part("mass")?, "value")?;
    let tensor = part("inertia")?;
    let moments = [number(tensor, "ixx")?, number(tensor, "iyy")?, number(tensor, "izz")?];
    let rounding = ROUNDING * moments.into_iter().fold(0.0, f64::max);
    for product in ["ixy", "ixz", "iyz"] {
        let value = optional(tensor, product, 0.0)?;
        if value.is_nan() || value.abs() > rounding {
            return Err(format!("{product} of `{name}` is {value}, not 0: the principal axes must be x, y and z"));
        }
    }
    let com = origin(inertial, name)?;
    let drawn = children(link, "visual").find_map(|visual| child(child(visual, "geometry")?, "box"));
    // only drawn, for the moments are given
    let size = drawn.map_or(Ok([0.05; 3]), |shape| vector(shape, "size"))?;
    let mut body = Body { name: name.into(), mass, size, com, ..Body::default() };
    if body.moments() != moments {
        body.inertia = Some(moments);
    }
    for collision in children(link, "collision") {
        touch(&mut body, collision)?;
    }
    body.joint = joint.map(|node| hinge(node)).transpose()?;
    Ok(body)
}

/// What a collision shape touches the ground with; shapes that never do are left out: cylinders, meshes.
fn touch(body: &mut Body, collision: Node) -> Parsed<()> {
    let Some(geometry) = child(collision, "geometry") else { return Ok(()) };
    let at = origin(collision, &body.name)?;
    if let Some(ball) = child(geometry, "sphere") {
        let radius = number(ball, "radius")?;
        match radius == POINT {
            true => body.contacts.push([at[0], at[1], below(at[2])]),
            false => body.spheres.push(Sphere { at, radius }),
        }
    }
    if let Some(shape) = child(geometry, "box") {
        let half = vector(shape, "size")?.map(|side| 0.5 * side);
        for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
            body.contacts.push([at[0] + x * half[0], at[1] + y * half[1], at[2] - half[2]]);
        }
    }
    Ok(())
}

/// The point under a ball of [`POINT`] as it was written: the shortest number that the ball's height comes from.
fn below(height: f64) -> f64 {
    let short = ((height - POINT) * 1e9).round() / 1e9;
    if short + POINT == height { short } else { height - POINT }
}

fn hinge(node: Node) -> Parsed<Joint> {
    let name = attribute(node, "name")?;
    let kind = match attribute(node, "type")? {
        "revolute" | "continuous" => JointKind::Revolute,
        "prismatic" => JointKind::Prismatic,
        other => return Err(format!("joint `{name}` is {other}, but it must turn or slide")),
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

/// Reflected inertia of each drive that says one: rotor inertia times the square of the gear's ratio.
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

/// The one value of all, if they are alike.
fn common(values: &[f64]) -> Option<f64> {
    values.first().copied().filter(|first| values.iter().all(|value| value == first))
}

/// The same, of what must be alike.
fn alike(what: &str, values: &[f64]) -> Parsed<Option<f64>> {
    let kinds: BTreeSet<String> = values.iter().map(f64::to_string).collect();
    match kinds.len() {
        0 | 1 => Ok(common(values)),
        _ => Err(format!("{what} differs from joint to joint ({kinds:?}), but the drives must be alike")),
    }
}

/// Where something is; nothing may be turned, for all frames are parallel at zero angles.
fn origin(node: Node, of: &str) -> Parsed<[f64; 3]> {
    let Some(origin) = child(node, "origin") else { return Ok([0.0; 3]) };
    if origin.attribute("rpy").is_some() && !vector(origin, "rpy")?.iter().all(|angle| angle.abs() <= ROUNDING) {
        return Err(format!(
            "`{of}` has an origin that is turned (rpy), but all frames must be parallel at zero angles"
        ));
    }
    origin.attribute("xyz").map_or(Ok([0.0; 3]), |_| vector(origin, "xyz"))
}

fn massless(root: Node, name: Option<&str>) -> bool {
    children(root, "link").any(|link| link.attribute("name") == name && child(link, "inertial").is_none())
}

fn children<'a>(node: Node<'a, 'a>, tag: &'static str) -> impl Iterator<Item = Node<'a, 'a>> {
    node.children().filter(move |child| child.tag_name().name() == tag)
}

fn child<'a>(node: Node<'a, 'a>, tag: &'static str) -> Option<Node<'a, 'a>> {
    children(node, tag).next()
}

fn linked<'a>(joint: Node<'a, 'a>, end: &'static str) -> Option<&'a str> {
    child(joint, end)?.attribute("link")
}

fn attribute<'a>(node: Node<'a, 'a>, key: &str) -> Parsed<&'a str> {
    node.attribute(key).ok_or_else(|| format!("a {} has no {key}", node.tag_name().name()))
}

fn number(node: Node, key: &str) -> Parsed<f64> {
    let text = attribute(node, key)?;
    text.trim().parse().map_err(|_| format!("{key}=\"{text}\" of {} is no number", node.tag_name().name()))
}

fn optional(node: Node, key: &str, otherwise: f64) -> Parsed<f64> {
    node.attribute(key).map_or(Ok(otherwise), |_| number(node, key))
}

fn vector(node: Node, key: &str) -> Parsed<[f64; 3]> {
    let text = attribute(node, key)?;
    let parts: Option<Vec<f64>> = text.split_whitespace().map(|part| part.parse().ok()).collect();
    let parts = parts.and_then(|parts| parts.try_into().ok());
    parts.ok_or_else(|| format!("{key}=\"{text}\" of {} is not three numbers", node.tag_name().name()))
}
