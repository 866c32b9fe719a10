//! Properties of links and frames that this simulator does not have. One sentence names all places with the first property found.

use super::super::listed::{has, listed, quoted};
use super::links::{Rigid, carrier, has_mass};
use super::xml::{Parsed, attribute, child, children, is_rotated, number, optional};
use roxmltree::Node;

/// Products of inertia up to this, over the largest moment, are rounding of the program that wrote the file [-].
const ROUNDING: f64 = 1e-9;

/// Refuses bodies without mass or with several masses, rotated frames, and axes of inertia that are not those of the frame.
pub(super) fn refuse(bodies: &[Rigid]) -> Parsed<()> {
    masses(bodies)?;
    rotations(bodies)?;
    products(bodies)
}

fn masses(bodies: &[Rigid]) -> Parsed<()> {
    let light: Vec<_> =
        bodies.iter().filter(|body| body.masses().next().is_none()).map(|body| quoted(body.name())).collect();
    if !light.is_empty() {
        return Err(format!(
            "{} {} no inertial: every link that moves needs mass and inertia",
            listed(&light),
            has(&light)
        ));
    }
    let mut extra = vec![];
    for body in bodies {
        extra.extend(body.masses().skip(1).map(|part| format!("`{}` to `{}`", part.name, body.name())));
    }
    let rule = "a body has one inertial: combine the links that are fixed to each other into one";
    if extra.is_empty() {
        Ok(())
    } else {
        Err(format!("fixed joints hold links with an inertial of their own, {}, but {rule}", listed(&extra)))
    }
}

fn rotations(bodies: &[Rigid]) -> Parsed<()> {
    let mut found = vec![];
    for body in bodies {
        if let Some(joint) = body.joint {
            if is_rotated(joint)? {
                found.push(format!("joint `{}`", attribute(joint, "name")?));
            }
            let turn = carrier(bodies, joint).and_then(|(_, part)| part.turned_by);
            found.extend(turn.map(|name| format!("joint `{name}`")));
        }
        for part in &body.parts {
            let collisions = || children(part.link, "collision");
            let is_used = has_mass(part.link) || collisions().next().is_some();
            found.extend(part.turned_by.filter(|_| is_used).map(|name| format!("joint `{name}`")));
            let inertial = child(part.link, "inertial").filter(|_| has_mass(part.link));
            for element in inertial.into_iter().chain(collisions()) {
                if is_rotated(element)? {
                    found.push(format!("the {} of `{}`", element.tag_name().name(), part.name));
                }
            }
        }
    }
    found.dedup();
    let rule = "a rotated origin (rpy), but all frames must be parallel at zero angles";
    if found.is_empty() { Ok(()) } else { Err(format!("{} {} {rule}", listed(&found), has(&found))) }
}

fn products(bodies: &[Rigid]) -> Parsed<()> {
    let mut found = vec![];
    for body in bodies {
        for part in body.masses() {
            found.extend(first_product(part.link)?.map(|(key, value)| format!("{key} of `{}` is {value}", part.name)));
        }
    }
    let rule = "not 0: the principal axes must be x, y and z";
    if found.is_empty() { Ok(()) } else { Err(format!("{}, {rule}", listed(&found))) }
}

/// The first product of inertia of a link that is no rounding error.
fn first_product(link: Node) -> Parsed<Option<(&'static str, f64)>> {
    let Some(tensor) = child(link, "inertial").and_then(|inertial| child(inertial, "inertia")) else { return Ok(None) };
    let moments = [number(tensor, "ixx")?, number(tensor, "iyy")?, number(tensor, "izz")?];
    let rounding = ROUNDING * moments.into_iter().fold(0.0, f64::max);
    for key in ["ixy", "ixz", "iyz"] {
        let value = optional(tensor, key, 0.0)?;
        if value.abs() > rounding {
            return Ok(Some((key, value)));
        }
    }
    Ok(None)
}
