//! The bipeds that the controller can drive: a trunk and two legs that are mirror images of each other. Each leg has hip pitch, knee
//! pitch, ankle pitch and ankle roll. The canonical form has the order, the names and the directions of rotation of
//! [`table_1`](super::table_1).

use super::shape::{LEG, legs};
use super::sole::require_flat_sole;
use super::{BIPED, Body, Joint, JointKind, TRUNK};

/// Relative difference of lengths, masses and inertias that counts as rounding [-].
const ROUNDING: f64 = 1e-9;

/// The bodies of a biped in canonical form: order and names are those of [`BIPED`]. An absent right leg is made as the mirror image of
/// the left one.
///
/// # Errors
/// Why the bodies are not a biped.
pub fn canonical_biped(bodies: &[Body]) -> Result<Vec<Body>, String> {
    let (trunk, mut legs) = legs(bodies)?;
    legs.sort_by(|a, b| lateral_position(b[0]).total_cmp(&lateral_position(a[0])));
    legs.iter().try_for_each(|leg| require_axes(leg))?;
    let left: Vec<Body> = legs[0].iter().copied().cloned().collect();
    let right: Vec<Body> = match legs.get(1) {
        Some(right) => right.iter().copied().cloned().collect(),
        None => left.iter().map(mirrored).collect(),
    };
    if lateral_position(&left[0]) <= 0.0 {
        return Err(format!("the hip of `{}` must lie to the left, at y > 0", left[0].name));
    }
    if trunk.com[1] != 0.0 {
        return Err(format!("the centre of mass of `{}` must lie between the legs, at y = 0", trunk.name));
    }
    let length = leg_length(&left);
    left.iter().zip(&right).try_for_each(|(left, right)| require_mirror_image(left, right, length))?;
    require_flat_sole(&left[LEG - 1])?;
    let ordered = left.iter().rev().chain([trunk]).chain(&right);
    Ok(ordered.enumerate().map(|(i, body)| with_canonical_name(body, i)).collect())
}

fn lateral_position(body: &Body) -> f64 {
    body.joint.as_ref().map_or(0.0, |joint| joint.at[1])
}

/// Length of a leg from the trunk to the sole's joint, the scale of a robot's lengths [m].
fn leg_length(leg: &[Body]) -> f64 {
    let at = |body: &Body| body.joint.as_ref().map_or(0.0, |joint| joint.at.iter().map(|x| x * x).sum::<f64>().sqrt());
    leg.iter().map(at).sum()
}

/// Checks that the joints of a leg pitch and, at the foot, roll.
fn require_axes(leg: &[&Body]) -> Result<(), String> {
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
    Ok(())
}

/// The mirror image in the plane y = 0. The contact points are sorted from front to back and from left to right, as in Table 1.
fn mirrored(body: &Body) -> Body {
    let flip = |[x, y, z]: [f64; 3]| [x, 0.0 - y, z];
    let mut image = Body { com: flip(body.com), ..body.clone() };
    if let Some(joint) = &mut image.joint {
        let [x, y, z] = joint.axis;
        (joint.at, joint.axis) = (flip(joint.at), [0.0 - x, y, 0.0 - z]); // a mirror reverses a turn about x or z
    }
    image.contacts = sorted(body.contacts.iter().copied().map(flip).collect());
    image.spheres.iter_mut().for_each(|ball| ball.at = flip(ball.at));
    image
}

fn sorted(mut points: Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    points.sort_by(|a, b| b[0].total_cmp(&a[0]).then(b[1].total_cmp(&a[1])));
    points
}

/// Checks that a body of the right leg is the mirror image of that of the left leg, in a robot whose legs have this length [m].
fn require_mirror_image(left: &Body, right: &Body, length: f64) -> Result<(), String> {
    let image = mirrored(left);
    let at = |body: &Body| body.joint.as_ref().map_or([0.0; 3], |joint| joint.at).to_vec();
    let of_joint = |body: &Body, value: fn(&Joint) -> f64| vec![body.joint.as_ref().map_or(0.0, value)];
    let rest = |body: &Body| body.joint.as_ref().map_or([0.0; 3], |joint| joint.axis.map(|a| a * joint.rest)).to_vec();
    let points = |body: &Body| sorted(body.contacts.clone()).concat();
    let balls = |body: &Body| sorted(body.spheres.iter().map(|ball| ball.at).collect()).concat();
    let radii = |body: &Body| {
        let mut balls = body.spheres.clone();
        balls.sort_by(|a, b| b.at[0].total_cmp(&a.at[0]).then(b.at[1].total_cmp(&a.at[1])));
        balls.iter().map(|ball| ball.radius).collect::<Vec<_>>()
    };
    // both values may be rounded
    let close = |a: &[f64], b: &[f64], scale: f64| {
        let rounding = |a: f64, b: f64| 2.0 * ROUNDING * scale.max(a.abs()).max(b.abs());
        a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (a - b).abs() <= rounding(*a, *b))
    };
    let moment = image.mass * length * length;
    let pairs = [
        ("mass", vec![image.mass], vec![right.mass], 0.0),
        ("com", image.com.to_vec(), right.com.to_vec(), length),
        ("inertia", image.moments().to_vec(), right.moments().to_vec(), moment),
        ("joint.at", at(&image), at(right), length),
        ("joint.stiffness", of_joint(&image, |joint| joint.stiffness), of_joint(right, |joint| joint.stiffness), 0.0),
        ("joint.damping", of_joint(&image, |joint| joint.damping), of_joint(right, |joint| joint.damping), 0.0),
        ("joint.rest about x, y, z", rest(&image), rest(right), 1.0),
        ("contacts", points(&image), points(right), length),
        ("spheres", balls(&image), balls(right), length),
        ("radius of spheres", radii(&image), radii(right), length),
    ];
    match pairs.iter().find(|(_, image, right, scale)| !close(image, right, *scale)) {
        None => Ok(()),
        Some((what, image, other, _)) => {
            let shown = |values: &[f64]| match values {
                [value] => value.to_string(),
                values => format!("{values:?}"),
            };
            let (image, other) = (shown(image), shown(other));
            let pair = format!("`{}` must be the mirror image of `{}`", right.name, left.name);
            Err(format!("{pair}: its {what} must be {image}, not {other}"))
        }
    }
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
    use crate::robot::{Sphere, table_1};

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
    fn springs_of_both_legs_are_mirror_images_of_each_other() {
        let mut bodies = table_1();
        for (k, body) in bodies.iter_mut().enumerate() {
            if let Some(joint) = &mut body.joint {
                (joint.stiffness, joint.rest) = (1.0, [0.1, 0.2, 0.3, 0.4, 0.0, -0.4, -0.3, -0.2, 0.1][k]);
            }
        }
        assert_eq!(canonical_biped(&bodies), Ok(bodies.clone()));
        assert_eq!(canonical_biped(&bodies[..5]), Ok(bodies.clone()), "the right leg made of the left one");
        bodies[8].joint.as_mut().expect("roll").rest = -0.1;
        assert!(canonical_biped(&bodies).is_err_and(|error| error.contains("its joint.rest")));
    }

    /// Table 1 with lengths in this ratio and masses by its cube. Each number but the places of contact points is multiplied by one that
    /// `noise` returns.
    fn scaled(ratio: f64, mut noise: impl FnMut() -> f64) -> Vec<Body> {
        let mut bodies = table_1();
        for body in &mut bodies {
            body.mass *= ratio.powi(3) * noise();
            body.inertia = Some(body.moments().map(|moment| ratio.powi(2) * moment * noise()));
            let joint = body.joint.iter_mut().map(|joint| &mut joint.at);
            for vector in [&mut body.size, &mut body.com].into_iter().chain(joint) {
                *vector = vector.map(|x| ratio * x * noise());
            }
            for point in &mut body.contacts {
                *point = [ratio * point[0], ratio * point[1], ratio * point[2] * noise()];
            }
        }
        bodies
    }

    #[test]
    fn a_robot_of_any_size_is_held_to_its_own_scale() {
        let seed = fastrand::u64(..);
        println!("seed {seed}");
        let mut random = fastrand::Rng::with_seed(seed);
        type Change = fn(&mut [Body], f64);
        let changes: [(Change, &str); 7] = [
            (
                |bodies, _| bodies[2].inertia = bodies[2].inertia.map(|moments| moments.map(|moment| 3.0 * moment)),
                "its inertia",
            ),
            (|bodies, _| bodies[2].mass *= 1.0001, "its mass"),
            (|bodies, ratio| bodies[2].com[2] += 1e-5 * ratio, "its com"),
            (|bodies, ratio| bodies[2].joint.as_mut().expect("a knee").at[2] += 1e-5 * ratio, "its joint.at"),
            (|bodies, ratio| bodies[0].contacts[0][0] += 1e-5 * ratio, "its contacts"),
            (
                |bodies, ratio| {
                    [(0, 0), (8, 1)].iter().for_each(|&(foot, k)| bodies[foot].contacts[k][2] += 1e-5 * ratio)
                },
                "flat sole",
            ),
            (
                |bodies, ratio| {
                    for foot in [0, 8] {
                        let side = if foot == 0 { ratio } else { -ratio };
                        bodies[foot].contacts =
                            [0.1, 0.0, -0.1].map(|x| [ratio * x, 0.5 * side * x, -0.05 * ratio]).into();
                    }
                },
                "flat sole",
            ),
        ];
        for ratio in [1e-6, 0.01, 0.02, 0.3, 1.0, 50.0] {
            for _ in 0..20 {
                let noisy = scaled(ratio, || 1.0 + 1e-9 * (2.0 * random.f64() - 1.0));
                assert_eq!(canonical_biped(&noisy).map(|_| ()), Ok(()), "length ratio {ratio}");
            }
            for (change, words) in changes {
                let mut bodies = scaled(ratio, || 1.0);
                change(&mut bodies, ratio);
                let error = canonical_biped(&bodies).expect_err(words);
                assert!(error.contains(words), "length ratio {ratio}: {error}");
            }
        }
    }

    #[test]
    fn other_robots_are_refused_with_a_reason() {
        let refused = |change: &dyn Fn(&mut Vec<Body>), words: &str| {
            let mut bodies = table_1();
            change(&mut bodies);
            let error = canonical_biped(&bodies).expect_err(words);
            assert!(error.contains(words), "{error}");
        };
        refused(&|bodies| drop(bodies.remove(0)), "has 3 joints, but a robot here is a trunk");
        refused(&|bodies| bodies.truncate(6), "has 1 joint, but");
        refused(
            &|bodies| bodies[7].mass = 0.6,
            "`right ankle` must be the mirror image of `left ankle`: its mass must be 0.5, not 0.6",
        );
        refused(&|bodies| bodies[8].contacts[2][0] = -0.2, "its contacts must be");
        let roll = |bodies: &mut Vec<Body>, damping| bodies[0].joint.as_mut().expect("roll").damping = damping;
        refused(&|bodies| roll(bodies, 0.1), "its joint.damping must be 0.1, not 0");
        let ball = Sphere { at: [0.0; 3], radius: 0.1 };
        refused(&|bodies| bodies[8].spheres.push(ball), "its spheres must be");
        refused(&|bodies| bodies.retain(|body| body.name == TRUNK), "carries 0 legs");
        refused(&|bodies| bodies[4].com[1] = 0.01, "at y = 0");
        refused(&|bodies| bodies[4].joint = bodies[3].joint.clone(), "0 bodies have no joint");
        refused(&|bodies| [0, 8].map(|i: usize| bodies[i].contacts.truncate(2)).into_iter().collect(), "flat sole");
        let axis = |bodies: &mut Vec<Body>, axis| bodies[2].joint.as_mut().expect("a knee").axis = axis;
        refused(&|bodies| axis(bodies, [0.0, 0.0, 1.0]), "must pitch about y");
        refused(&|bodies| bodies[2].joint.as_mut().expect("a knee").kind = JointKind::Prismatic, "prismatic");
        refused(&|bodies| bodies[0].joint.as_mut().expect("roll").axis = [0.0, 1.0, 0.0], "must roll about x");
    }
}
