//! The bipeds that the controller can drive: a trunk and two legs that are mirror images of each other. Each leg has hip pitch, knee
//! pitch, ankle pitch and ankle roll. The canonical form has the order, the names and the directions of rotation of
//! [`table_1`](super::table_1).

use super::{BIPED, Body, JointKind, TRUNK};

/// Number of bodies of one leg.
const LEG: usize = 4;
/// Relative difference of lengths, masses and inertias that counts as rounding [-].
const ROUNDING: f64 = 1e-9;

/// The bodies of a biped in canonical form: order and names are those of [`BIPED`]. An absent right leg is made as the mirror image of
/// the left one.
///
/// # Errors
/// Why the bodies are not a biped.
pub fn canonical_biped(bodies: &[Body]) -> Result<Vec<Body>, String> {
    let bases: Vec<&Body> = bodies.iter().filter(|body| body.joint.is_none()).collect();
    let [trunk] = bases[..] else {
        return Err(format!("{} bodies have no joint, but exactly one, the trunk, must have none", bases.len()));
    };
    let mut hips = children_of(bodies, trunk);
    hips.sort_by(|a, b| lateral_position(b).total_cmp(&lateral_position(a)));
    let mut legs = hips.iter().map(|hip| leg(bodies, hip)).collect::<Result<Vec<_>, _>>()?;
    let count = bodies.len();
    if legs.len() == 1 {
        legs.push(legs[0].iter().map(mirrored).collect());
    }
    let [left, right] = &legs[..] else {
        return Err(format!("`{}` carries {} legs, but a biped has two", trunk.name, legs.len()));
    };
    if count != 1 + hips.len() * LEG {
        return Err(format!("{} bodies are part of neither the trunk nor a leg", count - 1 - hips.len() * LEG));
    }
    if lateral_position(&left[0]) <= 0.0 {
        return Err(format!("the hip of `{}` must lie to the left, at y > 0", left[0].name));
    }
    if trunk.com[1] != 0.0 {
        return Err(format!("the centre of mass of `{}` must lie between the legs, at y = 0", trunk.name));
    }
    left.iter().zip(right).try_for_each(|(left, right)| require_mirror_image(left, right))?;
    require_flat_sole(&left[LEG - 1])?;
    let ordered = left.iter().rev().chain([trunk]).chain(right);
    Ok(ordered.enumerate().map(|(i, body)| with_canonical_name(body, i)).collect())
}

fn children_of<'a>(bodies: &'a [Body], parent: &Body) -> Vec<&'a Body> {
    bodies.iter().filter(|body| body.joint.as_ref().is_some_and(|joint| joint.parent == parent.name)).collect()
}

fn lateral_position(body: &Body) -> f64 {
    body.joint.as_ref().map_or(0.0, |joint| joint.at[1])
}

/// The bodies of a leg: thigh, shank, ankle and foot.
fn leg(bodies: &[Body], hip: &Body) -> Result<Vec<Body>, String> {
    let mut leg = vec![hip.clone()];
    while let [next, others @ ..] = &children_of(bodies, &leg[leg.len() - 1])[..] {
        if !others.is_empty() || leg.len() > bodies.len() {
            return Err(format!(
                "`{}` carries {} bodies, but each body of a leg carries at most one",
                leg[leg.len() - 1].name,
                1 + others.len()
            ));
        }
        leg.push((*next).clone());
    }
    if leg.len() != LEG {
        return Err(format!(
            "the leg that begins with `{}` has {} joints, but it needs four: hip, knee and ankle pitch, ankle roll",
            hip.name,
            leg.len()
        ));
    }
    for (k, body) in leg.iter().enumerate() {
        let Some(joint) = &body.joint else { continue };
        let (across, what) =
            if k == LEG - 1 { (0, "roll about x, [±1, 0, 0]") } else { (1, "pitch about y, [0, ±1, 0]") };
        let aligned = (0..3).all(|i| (joint.axis[i].abs() - f64::from(u8::from(i == across))).abs() < ROUNDING);
        let [x, y, z] = joint.axis;
        let fault = match joint.kind {
            JointKind::Prismatic => format!("is prismatic, but it must be revolute and {what}"),
            JointKind::Revolute if !aligned => format!("turns about {x}, {y}, {z}, but it must {what}"),
            JointKind::Revolute => continue,
        };
        return Err(format!("the joint of `{}` {fault}", body.name));
    }
    Ok(leg)
}

/// The mirror image in the plane y = 0. The contact points are sorted from front to back and from left to right, as in Table 1.
fn mirrored(body: &Body) -> Body {
    let flip = |[x, y, z]: [f64; 3]| [x, 0.0 - y, z];
    let mut image = Body { com: flip(body.com), ..body.clone() };
    if let Some(joint) = &mut image.joint {
        joint.at = flip(joint.at);
    }
    image.contacts = sorted(body.contacts.iter().copied().map(flip).collect());
    image.spheres.iter_mut().for_each(|ball| ball.at = flip(ball.at));
    image
}

fn sorted(mut points: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    points.sort_by(|a, b| b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1])));
    points
}

/// Checks that a body of the right leg is the mirror image of that of the left leg.
fn require_mirror_image(left: &Body, right: &Body) -> Result<(), String> {
    let image = mirrored(left);
    let at = |body: &Body| body.joint.as_ref().map_or([0.0; 3], |joint| joint.at).to_vec();
    let points = |body: &Body| sorted(body.contacts.clone()).concat();
    let close = |a: &[f64], b: &[f64]| {
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= ROUNDING * (1.0 + a.abs().max(b.abs())))
    };
    let pairs = [
        ("mass", vec![image.mass], vec![right.mass]),
        ("com", image.com.to_vec(), right.com.to_vec()),
        ("inertia", image.moments().to_vec(), right.moments().to_vec()),
        ("joint.at", at(&image), at(right)),
        ("contacts", points(&image), points(right)),
    ];
    match pairs.iter().find(|(_, image, right)| !close(image, right)) {
        None => Ok(()),
        Some((what, image, other)) => Err(format!(
            "`{}` must be the mirror image of `{}`, whose {what} requires {image:?}, not {other:?}",
            right.name, left.name
        )),
    }
}

/// Checks that a foot has a flat sole.
fn require_flat_sole(foot: &Body) -> Result<(), String> {
    let spread = |k: usize| {
        let values = || foot.contacts.iter().map(|point| point[k]);
        values().fold(f64::MIN, f64::max) - values().fold(f64::MAX, f64::min)
    };
    let flat = foot.contacts.len() >= 3 && spread(0) > 0.0 && spread(1) > 0.0 && spread(2) < ROUNDING;
    let what = "needs the corners of a flat sole: at least three contact points at the same height, not on one line";
    if flat { Ok(()) } else { Err(format!("`{}` {what}", foot.name)) }
}

/// The body with the canonical name, parent and direction of rotation of the position `index`.
fn with_canonical_name(body: &Body, index: usize) -> Body {
    let mut body = Body { name: BIPED[index].into(), ..body.clone() };
    if let Some(joint) = &mut body.joint {
        let toward_trunk = if body.name.starts_with("left") { index + 1 } else { index - 1 };
        joint.parent = BIPED[toward_trunk].into();
        let sense = if index < BIPED.len() / 2 { -1.0 } else { 1.0 };
        if joint.axis.iter().sum::<f64>() * sense < 0.0 {
            joint.rest = 0.0 - joint.rest;
        }
        let rolls = index == 0 || index == BIPED.len() - 1;
        joint.axis = if rolls { [sense, 0.0, 0.0] } else { [0.0, sense, 0.0] };
    }
    debug_assert_eq!(BIPED[LEG], TRUNK);
    body
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::table_1;

    #[test]
    fn table_1_is_canonical_and_its_left_half_determines_it() {
        assert_eq!(canonical_biped(&table_1()), Ok(table_1()));
        assert_eq!(canonical_biped(&table_1()[..5]), Ok(table_1()));
    }

    #[test]
    fn order_names_and_directions_of_rotation_do_not_matter() {
        let mut other = table_1();
        other.reverse();
        for body in &mut other {
            body.name = format!("my {}", body.name);
            if let Some(joint) = &mut body.joint {
                joint.parent = format!("my {}", joint.parent);
                joint.axis = joint.axis.map(f64::abs);
            }
        }
        assert_eq!(canonical_biped(&other), Ok(table_1()));
    }

    #[test]
    fn other_robots_are_refused_with_a_reason() {
        let refused = |change: &dyn Fn(&mut Vec<Body>), words: &str| {
            let mut bodies = table_1();
            change(&mut bodies);
            let error = canonical_biped(&bodies).expect_err(words);
            assert!(error.contains(words), "{error}");
        };
        refused(&|bodies| drop(bodies.remove(0)), "has 3 joints, but it needs four");
        refused(&|bodies| bodies.truncate(6), "has 1 joints");
        refused(&|bodies| bodies[7].mass = 0.6, "`right ankle` must be the mirror image of `left ankle`, whose mass");
        refused(&|bodies| bodies[8].contacts[2][0] = -0.2, "whose contacts");
        refused(&|bodies| bodies[4].com[1] = 0.01, "at y = 0");
        refused(&|bodies| bodies[4].joint = bodies[3].joint.clone(), "0 bodies have no joint");
        refused(&|bodies| [0, 8].map(|i: usize| bodies[i].contacts.truncate(2)).into_iter().collect(), "flat sole");
        let axis = |bodies: &mut Vec<Body>, axis| bodies[2].joint.as_mut().expect("a knee").axis = axis;
        refused(&|bodies| axis(bodies, [0.0, 0.0, 1.0]), "must pitch about y");
        refused(&|bodies| bodies[2].joint.as_mut().expect("a knee").kind = JointKind::Prismatic, "prismatic");
        refused(&|bodies| bodies[0].joint.as_mut().expect("roll").axis = [0.0, 1.0, 0.0], "must roll about x");
    }
}
