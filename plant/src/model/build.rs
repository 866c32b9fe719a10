//! Construction of a model from a scene: ordered tree, masses, payload and gravity, with every value checked.

use super::check::{finite, not_negative};
use super::contact_points::contact_points;
use super::{ContactPoint, Link, Model, Motion, Spring, unknown};
use crate::error::PlantError;
use crate::initial::{height_offset, orientation};
use crate::kinematics::Pose;
use crate::state::State;
use messages::robot::{Body, Joint, JointKind};
use messages::rotation;
use messages::scene::{Base, Law, Scene};
use nalgebra::{Matrix3, Vector3};

/// Least length of a joint axis as the scene gives it [-]; a shorter one has no direction.
const MIN_AXIS: f64 = 1e-12;

impl Model {
    /// Builds the model of a scene's bodies, base, payload and gravity.
    ///
    /// Gravity is tilted by the incline so that downhill is +x: g (sin a, 0, -cos a).
    ///
    /// # Errors
    /// One sentence on a body, tree, payload or initial pose that cannot be simulated.
    pub fn new(scene: &Scene) -> Result<Model, PlantError> {
        let bodies = &scene.bodies;
        let (mut links, body_link) = links(scene)?;
        let (path, path_start) = paths(&links);
        let tilt = scene.plant.incline_deg.to_radians();
        let jointed = |&(body, _): &(&Body, &usize)| body.joint.is_some();
        let mut contact_points = contact_points(bodies, &body_link)?;
        let base_link = virtual_links(scene.plant.base).len();
        let base_frame = match scene.plant.base {
            Base::Fixed => Vector3::zeros(),
            Base::Planar | Base::Virtual | Base::Quaternion => {
                -move_frame_to_com(&mut links, &mut contact_points, base_link)
            }
        };
        let ground = &scene.plant.ground;
        let mut model = Model {
            ground: (!ground.is_plane()).then(|| ground.clone()),
            length: length(&links, &contact_points),
            shares_load: contact_points.chunk_by(|a, b| a.link == b.link).nth(2).is_some(),
            base: scene.plant.base,
            gravity: Vector3::new(libm::sin(tilt), 0.0, -libm::cos(tilt))
                * not_negative(scene.plant.gravity, "gravity")?,
            mount_rotation: Matrix3::identity(),
            mount_position: Vector3::zeros(),
            base_link,
            base_frame,
            joint_dof: bodies.iter().zip(&body_link).filter(jointed).map(|(_, link)| link - 1).collect(),
            contact_points,
            directions: if matches!(scene.plant.law, Law::Aligned | Law::Cone) && moves_in_plane(scene) {
                1
            } else {
                2
            },
            springs: springs(bodies, &body_link, &links)?,
            body_name: bodies.iter().map(|body| body.name.clone()).collect(),
            branch_end: branch_ends(&links),
            links,
            body_link,
            path,
            path_start,
        };
        model.find_unmoved_points();
        model.mount(scene)?;
        Ok(model)
    }

    /// Places link 0 at the part of the initial pose that the base's coordinates cannot represent.
    fn mount(&mut self, scene: &Scene) -> Result<(), PlantError> {
        let position = finite(scene.initial.position, || "the initial position".into())?;
        match self.base {
            Base::Fixed => {
                self.mount_rotation = orientation(&scene.initial)?;
                self.mount_position = position;
                if let Some(clearance) = scene.initial.clearance {
                    let pose = Pose::of(self, &State::initial(self, &scene.initial)?);
                    self.mount_position.z += height_offset(self, &pose, clearance)?;
                }
            }
            Base::Planar => self.mount_position.y = position.y - self.base_frame.y,
            Base::Virtual | Base::Quaternion => {}
        }
        Ok(())
    }
}

/// Whether nothing in the scene can move along y or turn about x or z.
pub(crate) fn moves_in_plane(scene: &Scene) -> bool {
    let [roll, _, yaw] = scene.initial.orientation_deg;
    let base = scene.plant.base == Base::Planar || scene.plant.base == Base::Fixed && roll == 0.0 && yaw == 0.0;
    let joints = scene.bodies.iter().filter_map(|body| body.joint.as_ref());
    let in_plane = |joint: &Joint| match joint.kind {
        JointKind::Revolute => joint.axis[0] == 0.0 && joint.axis[2] == 0.0,
        JointKind::Prismatic => joint.axis[1] == 0.0,
    };
    base && joints.into_iter().all(in_plane)
}

/// The links, parents first, and the link of each body.
fn links(scene: &Scene) -> Result<(Vec<Link>, Vec<usize>), PlantError> {
    let bodies = &scene.bodies;
    let mut links = vec![virtual_link(0, Motion::Prismatic, Vector3::zeros())];
    links.extend(virtual_links(scene.plant.base));
    let base_link = links.len() - 1;
    let mut body_link = vec![base_link; bodies.len()];
    for (index, parent) in depth_first(bodies)? {
        let body = &bodies[index];
        if let Some(joint) = &body.joint {
            let motion = match joint.kind {
                JointKind::Revolute => Motion::Revolute,
                JointKind::Prismatic => Motion::Prismatic,
            };
            body_link[index] = links.len();
            links.push(Link {
                at: finite(joint.at, || format!("the joint of body `{}`", body.name))?,
                drive_inertia: not_negative(scene.plant.drive_inertia, "the drive inertia")?,
                damping: not_negative(scene.plant.joint_damping + joint.damping, "the joint damping")?,
                ..virtual_link(body_link[parent], motion, unit(joint.axis, &body.name)?)
            });
        }
        set_mass(&mut links[body_link[index]], body)?;
    }
    add_payload(&mut links, scene, &body_link, base_link)?;
    Ok((links, body_link))
}

/// Moves the frame of a link to its centre of mass, so that no motion depends on where the scene places the frame: an integration method
/// moves the frame along straight lines. Returns the displacement.
fn move_frame_to_com(links: &mut [Link], contact_points: &mut [ContactPoint], index: usize) -> Vector3<f64> {
    let com = std::mem::take(&mut links[index].com);
    links.iter_mut().skip(index + 1).filter(|link| link.parent == index).for_each(|link| link.at -= com);
    contact_points.iter_mut().filter(|point| point.link == index).for_each(|point| point.at -= com);
    com
}

/// Greatest distance of a contact or a joint from the centre of mass of the body that carries it [m].
fn length(links: &[Link], contact_points: &[ContactPoint]) -> f64 {
    let reaches = contact_points.iter().map(|point| (point.at - links[point.link].com).norm() + point.radius);
    let massive = links.iter().filter(|link| link.mass > 0.0);
    let joints = massive.map(|link| link.com.norm().max((link.at - links[link.parent].com).norm()));
    let jointed = links.len() > 1 + links.iter().filter(|link| link.mass == 0.0).count();
    reaches.chain(joints.filter(|_| jointed)).fold(0.0, f64::max)
}

/// The springs and dampers of the joints that have one.
fn springs(bodies: &[Body], body_link: &[usize], links: &[Link]) -> Result<Vec<Spring>, PlantError> {
    let mut springs = vec![];
    for (body, &link) in bodies.iter().zip(body_link) {
        let damping = links[link].damping;
        let Some(joint) = body.joint.as_ref().filter(|joint| joint.stiffness != 0.0 || damping != 0.0) else {
            continue;
        };
        let stiffness = not_negative(joint.stiffness, "the joint stiffness")?;
        let rest = finite([joint.rest; 3], || format!("the rest angle of body `{}`", body.name))?.x;
        springs.push(Spring { dof: link - 1, stiffness, damping, rest, coupling: 1.0 });
    }
    Ok(springs)
}

/// The paths of all links, one after the other, and the start of each.
fn paths(links: &[Link]) -> (Vec<usize>, Vec<usize>) {
    let (mut path, mut start) = (vec![], vec![0]);
    for (i, link) in links.iter().enumerate() {
        if i > 0 {
            path.extend_from_within(start[link.parent]..start[link.parent + 1]);
            path.push(i - 1);
        }
        start.push(path.len());
    }
    (path, start)
}

/// End of the branch of each degree of freedom.
fn branch_ends(links: &[Link]) -> Vec<usize> {
    let mut ends: Vec<usize> = (1..links.len()).collect();
    for i in (1..links.len()).rev() {
        if let Some(above) = links[i].parent.checked_sub(1) {
            ends[above] = ends[above].max(ends[i - 1]);
        }
    }
    ends
}

/// Bodies with the indices of their parents. Each parent comes before its children, and each branch is contiguous.
fn depth_first(bodies: &[Body]) -> Result<Vec<(usize, usize)>, PlantError> {
    let names: Vec<&str> = bodies.iter().map(|body| body.name.as_str()).collect();
    let find = |name: &str| names.iter().position(|known| *known == name);
    let mut parent = vec![0; bodies.len()];
    for (i, body) in bodies.iter().enumerate() {
        if find(&body.name) != Some(i) {
            return Err(PlantError::Duplicate { name: body.name.clone() });
        }
        if let Some(joint) = &body.joint {
            let what = format!("the joint of body `{}`", body.name);
            parent[i] = find(&joint.parent).ok_or_else(|| unknown(&what, &joint.parent, &names.join(", ")))?;
        }
    }
    let bases: Vec<usize> = (0..bodies.len()).filter(|&i| bodies[i].joint.is_none()).collect();
    let &[base] = &bases[..] else {
        return Err(PlantError::Base { names: bases.iter().map(|&i| bodies[i].name.clone()).collect() });
    };
    let (mut order, mut stack, mut seen) = (vec![], vec![base], vec![false; bodies.len()]);
    while let Some(i) = stack.pop() {
        seen[i] = true;
        order.push((i, parent[i]));
        stack.extend((0..bodies.len()).rev().filter(|&child| bodies[child].joint.is_some() && parent[child] == i));
    }
    match seen.iter().position(|&seen| !seen) {
        Some(lost) => Err(PlantError::Cycle { body: bodies[lost].name.clone() }),
        None => Ok(order),
    }
}

fn virtual_link(parent: usize, motion: Motion, axis: Vector3<f64>) -> Link {
    Link {
        parent,
        carrier: parent,
        motion,
        axis,
        along: rotation::aligned_axis(&axis),
        at: Vector3::zeros(),
        mass: 0.0,
        com: Vector3::zeros(),
        moments: Vector3::zeros(),
        reduced_mass: 0.0,
        payload_arm: Vector3::zeros(),
        drive_inertia: 0.0,
        damping: 0.0,
    }
}

/// The virtual links of Fig. 1 for the base's coordinates.
fn virtual_links(base: Base) -> Vec<Link> {
    use Motion::{Prismatic, Revolute, Spin};
    let (x, y, z) = (Vector3::x(), Vector3::y(), Vector3::z());
    let motions = match base {
        Base::Fixed => vec![],
        Base::Planar => vec![(Prismatic, x), (Prismatic, z), (Revolute, y)],
        Base::Virtual => {
            vec![(Prismatic, x), (Prismatic, y), (Prismatic, z), (Revolute, z), (Revolute, y), (Revolute, x)]
        }
        Base::Quaternion => vec![(Prismatic, x), (Prismatic, y), (Prismatic, z), (Spin, x), (Spin, y), (Spin, z)],
    };
    let link = |(parent, (motion, axis))| Link {
        carrier: if motion == Spin { 3 } else { parent },
        ..virtual_link(parent, motion, axis)
    };
    motions.into_iter().enumerate().map(link).collect()
}

/// Gives a link the mass properties of its body.
fn set_mass(link: &mut Link, body: &Body) -> Result<(), PlantError> {
    let of = |what: &str| format!("the {what} of body `{}`", body.name);
    let positive = |value: f64| value > 0.0 && value.is_finite();
    let moments = body.moments();
    if !positive(body.mass) {
        return Err(PlantError::value(of("mass"), body.mass, "greater than 0 kg"));
    }
    if !moments.into_iter().all(positive) {
        return Err(PlantError::value(of("inertia"), moments, "three moments greater than 0 kg·m²"));
    }
    link.mass = body.mass;
    link.com = finite(body.com, || of("centre of mass"))?;
    link.moments = moments.into();
    Ok(())
}

/// Adds the scene's payload, a point mass, to the link of its body.
fn add_payload(links: &mut [Link], scene: &Scene, body_link: &[usize], base_link: usize) -> Result<(), PlantError> {
    let plant = &scene.plant;
    let mass = not_negative(plant.payload_kg, "the payload")?;
    let offset = finite(plant.payload_offset, || "the offset of the payload".into())?;
    let names: Vec<&str> = scene.bodies.iter().map(|body| body.name.as_str()).collect();
    let link = match names.iter().position(|name| *name == plant.payload_body) {
        Some(index) => body_link[index],
        None if plant.payload_body.is_empty() => base_link,
        None => return Err(unknown("the payload", &plant.payload_body, &names.join(", "))),
    };
    let link = &mut links[link];
    let total = link.mass + mass;
    link.reduced_mass = link.mass * mass / total;
    link.payload_arm = offset - link.com;
    link.com += link.payload_arm * (mass / total);
    link.mass = total;
    Ok(())
}

fn unit(axis: [f64; 3], body: &str) -> Result<Vector3<f64>, PlantError> {
    let rule = || PlantError::value(format!("the joint axis of body `{body}`"), axis, "a direction, not zero");
    Vector3::from(axis).try_normalize(MIN_AXIS).filter(|axis| axis.iter().all(|c| c.is_finite())).ok_or_else(rule)
}
