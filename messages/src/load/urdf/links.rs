//! The rigid bodies of a URDF file: links that `fixed` joints hold together are one body. All work grows with the number of links, not with
//! its square, because a file may have very many.

use super::super::listed::{listed, quoted};
use super::xml::{Parsed, attribute, child, children, is_fixed, is_rotated, linked, position};
use crate::robot::{Body, Joint, require_biped_tree, require_few_joints};
use roxmltree::Node;
use std::collections::{BTreeMap, BTreeSet};

/// Name of the link to which other programs fix a robot. It is no part of the robot.
pub(super) const WORLD: &str = "world";

/// A link within its body.
pub(super) struct Part<'a> {
    pub(super) link: Node<'a, 'a>,
    pub(super) name: &'a str,
    /// Position of the link's frame in the frame of the body [m].
    pub(super) at: [f64; 3],
    /// Joint that turns the link relative to the body.
    pub(super) turned_by: Option<&'a str>,
}

/// Links that move as one.
pub(super) struct Rigid<'a> {
    /// The joint that moves it; none for the trunk.
    pub(super) joint: Option<Node<'a, 'a>>,
    /// Its links. The first one is at the joint.
    pub(super) parts: Vec<Part<'a>>,
}

impl<'a> Rigid<'a> {
    /// Links that have mass.
    pub(super) fn masses(&self) -> impl Iterator<Item = &Part<'a>> {
        self.parts.iter().filter(|part| has_mass(part.link))
    }

    /// Name of the body: that of its link with mass.
    pub(super) fn name(&self) -> &'a str {
        self.masses().chain(&self.parts).next().map_or("", |part| part.name)
    }
}

/// The bodies of a file, if they are a trunk and two legs. Links without mass that nothing hangs on are left out.
pub(super) fn bodies<'a>(root: Node<'a, 'a>) -> Parsed<Vec<Rigid<'a>>> {
    let joints: Vec<Node> = children(root, "joint").filter(|joint| !is_mount(*joint)).collect();
    require_few_joints(joints.iter().filter(|joint| !is_fixed(**joint)).count())?;
    let mut held: BTreeMap<&str, Node> = BTreeMap::new();
    let mut below: BTreeMap<&str, Vec<Node>> = BTreeMap::new();
    for joint in joints {
        held.insert(linked(joint, "child").unwrap_or_default(), joint);
        below.entry(linked(joint, "parent").unwrap_or_default()).or_default().push(joint);
    }
    let links: BTreeMap<&str, Node> =
        children(root, "link").map(|link| Ok((attribute(link, "name")?, link))).collect::<Parsed<_>>()?;
    let first =
        children(root, "link").filter_map(|link| link.attribute("name")).filter(|name| !held.contains_key(name));
    let mut starts: Vec<(&str, Option<Node>)> = first.map(|name| (name, None)).collect();
    let (mut bodies, mut reached, mut next) = (vec![], BTreeSet::new(), 0);
    while let Some(&(start, joint)) = starts.get(next) {
        next += 1;
        let mut body = Rigid { joint, parts: vec![] };
        let mut open = vec![(start, [0.0; 3], None)];
        while let Some((name, at, turned_by)) = open.pop() {
            let link = *links.get(name).ok_or(format!("there is no link `{name}`"))?;
            body.parts.push(Part { link, name, at, turned_by });
            reached.insert(name);
            for &joint in below.get(name).into_iter().flatten().rev() {
                let to = linked(joint, "child").unwrap_or_default();
                if is_fixed(joint) {
                    let turn = is_rotated(joint)?.then(|| joint.attribute("name").unwrap_or_default());
                    open.push((to, sum(at, position(joint)?), turned_by.or(turn)));
                } else {
                    starts.push((to, Some(joint)));
                }
            }
        }
        bodies.push(body);
    }
    let circle: Vec<_> = links.keys().filter(|name| !reached.contains(*name)).map(|name| quoted(name)).collect();
    if !circle.is_empty() {
        return Err(format!("the joints form a circle, so no trunk carries these links: {}", listed(&circle)));
    }
    let is_needed = |body: &Rigid| {
        let carries =
            body.parts.iter().any(|part| below.get(part.name).into_iter().flatten().any(|joint| !is_fixed(*joint)));
        let touches = body.parts.iter().any(|part| child(part.link, "collision").is_some() && part.name != WORLD);
        body.joint.is_some() || carries || touches || body.masses().next().is_some()
    };
    bodies.retain(is_needed);
    bodies.sort_by_key(|body| body.parts[0].link.id().get()); // the order of the file
    bodies.iter_mut().for_each(move_frame_to_trunk);
    require_one_trunk(&bodies)?;
    require_biped_tree(&skeleton(&bodies))?;
    Ok(bodies)
}

/// Whether a joint fixes the robot to the link [`WORLD`].
pub(super) fn is_mount(joint: Node) -> bool {
    is_fixed(joint) && linked(joint, "parent") == Some(WORLD)
}

/// Whether a link has mass or moments of inertia. Some programs write frames as links with a mass of 0.
pub(super) fn has_mass(link: Node) -> bool {
    let value =
        |tag: &'static str, key: &str| child(child(link, "inertial")?, tag)?.attribute(key)?.trim().parse().ok();
    let parts = [("mass", "value"), ("inertia", "ixx"), ("inertia", "iyy"), ("inertia", "izz")];
    child(link, "inertial").is_some() && !parts.into_iter().all(|(tag, key)| value(tag, key) == Some(0.0))
}

/// The body that carries a joint, and the place of the joint's parent link in it.
pub(super) fn carrier<'b, 'a>(bodies: &'b [Rigid<'a>], joint: Node) -> Option<(&'b Rigid<'a>, &'b Part<'a>)> {
    let name = linked(joint, "parent");
    bodies.iter().find_map(|body| Some((body, body.parts.iter().find(|part| Some(part.name) == name)?)))
}

/// A place in the frame of a body. Without an offset it keeps its bits.
pub(super) fn sum(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    if a == [0.0; 3] { b } else { std::array::from_fn(|i| a[i] + b[i]) }
}

/// The frame of the trunk is that of its link with mass. Any other body has its frame at its joint.
fn move_frame_to_trunk(body: &mut Rigid) {
    let Some(frame) = body.masses().next().map(|part| part.at).filter(|_| body.joint.is_none()) else { return };
    if frame != [0.0; 3] {
        body.parts.iter_mut().for_each(|part| part.at = std::array::from_fn(|i| part.at[i] - frame[i]));
    }
}

fn require_one_trunk(bodies: &[Rigid]) -> Parsed<()> {
    let bases: Vec<String> =
        bodies.iter().filter(|body| body.joint.is_none()).map(|body| quoted(body.name())).collect();
    match bases.len() {
        0 => Err("the file has no link with mass: a robot is a trunk with two legs".into()),
        1 => Ok(()),
        count => {
            Err(format!("{count} links hang on no joint, but only the trunk must hang on none: {}", listed(&bases)))
        }
    }
}

/// The tree without lengths, masses and axes.
fn skeleton(bodies: &[Rigid]) -> Vec<Body> {
    let bone = |body: &Rigid| {
        let parent = body.joint.and_then(|joint| Some(carrier(bodies, joint)?.0.name()));
        let joint = parent.map(|parent| Joint { parent: parent.into(), ..Joint::default() });
        Body { name: body.name().into(), joint, ..Body::default() }
    };
    bodies.iter().map(bone).collect()
}
