//! Reduction of a scene to the smallest model with the same motion: fewer coordinates and fewer contact points.
//!
//! | what is removed | condition |
//! |---|---|
//! | contact points that can never touch | the flight of the centre of mass, or the reach from a fixed base, keeps them above the ground |
//! | y, yaw and roll of the base | the scene is symmetric about the plane of x and z, so it stays symmetric |
//! | contact points of a body that differ in y alone, except one at their mean y | nothing moves across that plane, so they move as one |
//! | friction across that plane | the same; [`Model::directions`](crate::model::Model) |
//!
//! A scene with a controller or with uneven ground stays as it is.
//!
//! Each rule is exact: motion, total force on each body and zero-moment point are the same to rounding. Where Coulomb's law has several
//! solutions, such as the sideways force between two feet, the smaller model may have another solution.
//!
//! A push during the run is not part of the scene. It may break the symmetry, or bring down a point that was removed. So a run uses the
//! reduced model only on request, and only where no push can be requested.

use crate::contact::is_coulomb;
use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::Model;
use crate::model::build::moves_in_plane;
use crate::state::State;
use messages::robot::{Body, Joint, JointKind, Sphere};
use messages::scene::{Base, Law, Scene};
use std::collections::BTreeSet;
use std::fmt;

/// A scene on its smallest sufficient model.
#[derive(Clone, Debug, PartialEq)]
pub struct Smallest {
    /// The scene.
    pub scene: Scene,
    /// Size of the model of the original scene.
    pub full: Size,
    /// Size of the reduced model.
    pub size: Size,
}

/// How large a model is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Size {
    /// Coordinates of the base.
    pub base: Base,
    /// Degrees of freedom.
    pub dofs: usize,
    /// Contact points and balls.
    pub contacts: usize,
    /// Tangents along which friction acts.
    pub directions: usize,
}

/// Reduces a scene to its smallest model.
///
/// # Errors
/// If the scene cannot be simulated; see [`PlantError`].
pub fn smallest(written: &Scene) -> Result<Smallest, PlantError> {
    let full = Size::of(written)?;
    let mut scene = written.clone();
    if scene.controller.is_some() || !scene.plant.ground.is_plane() {
        return Ok(Smallest { scene, full, size: full }); // a controller may cause any motion; tiles break the symmetry
    }
    drop_untouchable(&mut scene)?;
    let movable = matches!(scene.plant.base, Base::Virtual | Base::Quaternion);
    if movable && is_its_mirror_image(&scene) {
        scene.plant.base = Base::Planar;
    }
    if scene.plant.base == Base::Planar && moves_in_plane(&scene) && is_coulomb(scene.plant.law) {
        scene.bodies.iter_mut().for_each(merge);
    }
    let size = Size::of(&scene)?;
    Ok(Smallest { scene: if size == full { written.clone() } else { scene }, full, size })
}

impl Smallest {
    /// Whether the reduced model is smaller than the original one.
    pub fn is_smaller(&self) -> bool {
        self.size != self.full
    }
}

impl Size {
    /// Size of the model of a scene.
    ///
    /// # Errors
    /// If the scene cannot be simulated; see [`PlantError`].
    pub fn of(scene: &Scene) -> Result<Size, PlantError> {
        let model = Model::new(scene)?;
        let (dofs, contacts) = (model.dofs(), model.contact_points.len());
        let directions = crate::contact::tangents(scene.plant.law).min(model.directions);
        Ok(Size { base: model.base, dofs, contacts, directions })
    }
}

impl fmt::Display for Size {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Size { base, dofs, contacts, directions } = self;
        let base = format!("{base:?}").to_lowercase();
        let s = if *directions == 1 { "" } else { "s" };
        write!(
            f,
            "{base} base, {dofs} degrees of freedom, {contacts} contact points, {directions} friction direction{s} per contact"
        )
    }
}

/// Removes contact points that cannot reach the ground during the scene.
///
/// Revolute joints move a point no further from the base than the sum of the lengths in between. Without contact and push, the centre of
/// mass flies on a parabola, whose lowest point is one of its ends.
fn drop_untouchable(scene: &mut Scene) -> Result<(), PlantError> {
    let slides = |body: &Body| body.joint.as_ref().is_some_and(|joint| joint.kind == JointKind::Prismatic);
    let plant = &scene.plant;
    if plant.payload_kg > 0.0 || plant.push_impulse != [0.0; 3] || scene.bodies.iter().any(slides) {
        return Ok(());
    }
    let model = Model::new(scene)?;
    let state = State::initial(&model, &scene.initial)?;
    let pose = Pose::of(&model, &state);
    let totals = kinematics::totals(&model, &state, &pose);
    let from_base: Vec<f64> = (0..scene.bodies.len()).map(|i| distance_from_base(&scene.bodies, i)).collect();
    let least = if model.base == Base::Fixed {
        pose.reference.z
    } else {
        let time = scene.duration;
        let end = totals.com.z + time * (totals.com_velocity.z + 0.5 * time * model.gravity.z);
        let reach =
            scene.bodies.iter().zip(&from_base).map(|(body, way)| body.mass * (way + norm(body.com))).sum::<f64>();
        totals.com.z.min(end) - reach / totals.mass
    };
    let touches = |i: usize, at: [f64; 3], radius: f64| least <= from_base[i] + norm(at) + radius;
    let bodies = scene.bodies.iter().enumerate();
    let some = bodies.map(|(i, body)| body.contact_spheres().any(|touch| touches(i, touch.at, touch.radius)));
    // after a first touch, the flight of a free base is no longer a parabola
    if model.base != Base::Fixed && some.into_iter().any(|some| some) {
        return Ok(());
    }
    if scene.initial.clearance.take().is_some() {
        scene.initial.position[2] = pose.reference.z; // the height that the clearance gave
    }
    for (i, body) in scene.bodies.iter_mut().enumerate() {
        body.contacts.retain(|&at| touches(i, at, 0.0));
        body.spheres.retain(|ball| touches(i, ball.at, ball.radius));
    }
    Ok(())
}

/// Greatest possible distance of a body's origin from the base's origin [m].
fn distance_from_base(bodies: &[Body], mut i: usize) -> f64 {
    let mut way = 0.0;
    while let Some(joint) = &bodies[i].joint {
        way += norm(joint.at);
        i = bodies.iter().position(|body| body.name == joint.parent).unwrap_or(i);
    }
    way
}

fn norm(v: [f64; 3]) -> f64 {
    v.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Whether the scene is symmetric about the plane of x and z through the base, in its initial state and in its laws of motion. It then
/// stays symmetric.
fn is_its_mirror_image(scene: &Scene) -> bool {
    let (plant, initial) = (&scene.plant, &scene.initial);
    let lawful = !matches!(plant.law, Law::Sweep(_)); // the order of the sweeps breaks the symmetry
    let alone = plant.payload_kg == 0.0 && plant.push_impulse == [0.0; 3];
    let [roll, _, yaw] = initial.orientation_deg;
    let straight = roll == 0.0 && yaw == 0.0 && initial.velocity[1] == 0.0;
    let level = initial.angular_velocity[0] == 0.0 && initial.angular_velocity[2] == 0.0;
    let count = scene.bodies.len();
    let images: BTreeSet<usize> = (0..count).filter_map(|i| mirror_image(scene, i, count)).collect();
    lawful && alone && straight && level && images.len() == count // each body is the image of another or of itself
}

/// The mirror image of body i, if there is one. `depth` limits the search along its parents.
fn mirror_image(scene: &Scene, i: usize, depth: usize) -> Option<usize> {
    let bodies = &scene.bodies;
    let Some(joint) = &bodies[i].joint else {
        return are_mirror_images(&bodies[i], &bodies[i]).then_some(i);
    };
    let parent = bodies.iter().position(|body| body.name == joint.parent)?;
    let parent = mirror_image(scene, parent, depth.checked_sub(1)?)?;
    let mut candidates = (0..bodies.len()).filter(|&j| {
        let of_parent = |joint: &&Joint| joint.parent == bodies[parent].name;
        let Some(other) = bodies[j].joint.as_ref().filter(of_parent) else { return false };
        let [x, y, z] = joint.axis;
        // a mirrored rotation has the opposite sign about the mirrored axis
        let image = if joint.kind == JointKind::Revolute { [-x, y, -z] } else { [x, -y, z] };
        let signs = [1.0, -1.0].into_iter().filter(|sign| other.axis == image.map(|part| sign * part));
        let same = |sign: f64| {
            let of = |list: &[f64], body: usize| list.get(joint_index(bodies, body)).copied().unwrap_or(0.0);
            let lists = [&scene.initial.joints, &scene.initial.joint_rates];
            other.rest == sign * joint.rest && lists.iter().all(|list| of(list, j) == sign * of(list, i))
        };
        let joints = other.kind == joint.kind && other.at == mirrored(joint.at);
        let springs = other.stiffness == joint.stiffness && other.damping == joint.damping;
        joints && springs && are_mirror_images(&bodies[i], &bodies[j]) && signs.into_iter().any(same)
    });
    candidates.next()
}

/// Index of a body's joint among all joints.
fn joint_index(bodies: &[Body], body: usize) -> usize {
    bodies[..body].iter().filter(|body| body.joint.is_some()).count()
}

/// Whether one body is the mirror image of the other, apart from their joints.
fn are_mirror_images(a: &Body, b: &Body) -> bool {
    let touches = |body: &Body| body.contact_spheres().collect::<Vec<_>>();
    let (ours, theirs) = (touches(a), touches(b));
    let image = |touch: &Sphere| Sphere { at: mirrored(touch.at), radius: touch.radius };
    let same_touches = ours.len() == theirs.len() && ours.iter().all(|touch| theirs.contains(&image(touch)));
    let same_mass = a.mass == b.mass && a.moments() == b.moments() && b.com == mirrored(a.com);
    same_mass && same_touches && a.tiles == b.tiles
}

fn mirrored([x, y, z]: [f64; 3]) -> [f64; 3] {
    [x, -y, z]
}

/// Merges contact points, and balls, that differ in y alone.
fn merge(body: &mut Body) {
    let points: Vec<_> = body.contacts.iter().map(|&at| Sphere { at, radius: 0.0 }).collect();
    body.contacts = merged(&points).iter().map(|point| point.at).collect();
    body.spheres = merged(&body.spheres);
}

/// Replaces touches that differ in y alone by one at their mean y, where their resultant acts if their impulses are equal.
fn merged(touches: &[Sphere]) -> Vec<Sphere> {
    let across = |touch: &Sphere| [touch.at[0], touch.at[2], touch.radius];
    let mut ones: Vec<Sphere> = vec![];
    for touch in touches {
        if ones.iter().any(|one| across(one) == across(touch)) {
            continue;
        }
        let row: Vec<f64> = touches.iter().filter(|other| across(other) == across(touch)).map(|it| it.at[1]).collect();
        let [x, _, z] = touch.at;
        ones.push(Sphere { at: [x, row.iter().sum::<f64>() / row.len() as f64, z], radius: touch.radius });
    }
    ones
}
