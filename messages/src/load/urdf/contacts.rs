//! Contact points and balls from the collision shapes of a URDF file.

use super::super::listed::listed;
use super::links::{Part, sum};
use super::xml::{Parsed, children, length, lengths, position};
use crate::robot::{Body, Sphere};
use roxmltree::Node;

/// Heights of contact points are rounded to this grid: nanometres [1/m].
const GRID: f64 = 1e9;
/// Radius of the balls that represent contact points [m].
const POINT_RADIUS: f64 = 1e-3;

/// Shapes of the collisions of a link.
fn shapes<'a>(link: Node<'a, 'a>) -> impl Iterator<Item = (Node<'a, 'a>, Node<'a, 'a>)> {
    let geometries = |collision| children(collision, "geometry").map(move |geometry| (collision, geometry));
    let parts = |(collision, geometry): (Node<'a, 'a>, Node<'a, 'a>)| {
        geometry.children().filter(Node::is_element).map(move |shape| (collision, shape))
    };
    children(link, "collision").flat_map(geometries).flat_map(parts)
}

/// Refuses shapes that touch the ground with other points than those that are simulated. One sentence names all of them.
pub(super) fn refuse_other_shapes<'a>(links: impl Iterator<Item = &'a Part<'a>>) -> Parsed<()> {
    let mut found = vec![];
    for part in links {
        for (_, shape) in shapes(part.link) {
            let kind = shape.tag_name().name();
            let words = format!("`{}` has a {kind}", part.name);
            if !matches!(kind, "box" | "sphere") && found.last() != Some(&words) {
                found.push(words);
            }
        }
    }
    let rule = "only spheres and boxes touch the ground here: use them, or remove the collision";
    if found.is_empty() { Ok(()) } else { Err(format!("the collision of {}, but {rule}", listed(&found))) }
}

/// Adds the contact points and balls of a link to the body that it is part of.
pub(super) fn add(body: &mut Body, part: &Part) -> Parsed<()> {
    for (collision, shape) in shapes(part.link) {
        let at = sum(part.at, position(collision)?);
        match shape.tag_name().name() {
            "sphere" => match length(shape, "radius")? {
                POINT_RADIUS => body.contacts.push([at[0], at[1], point_height(at[2])]),
                radius => body.spheres.push(Sphere { at, radius }),
            },
            _ => {
                let half = lengths(shape, "size")?.map(|side| 0.5 * side);
                for (x, y) in [(1.0, 1.0), (1.0, -1.0), (-1.0, 1.0), (-1.0, -1.0)] {
                    body.contacts.push([at[0] + x * half[0], at[1] + y * half[1], at[2] - half[2]]);
                }
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
