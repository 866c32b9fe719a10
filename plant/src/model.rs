//! The robot as the dynamics see it: a tree of links with one degree of freedom each, built once and constant.
//!
//! Link 0 is the paper's "virtual base link", fixed in W. Link i > 0 moves against its parent by the degree of freedom
//! i - 1; parents come before children, each branch in one piece. The base's coordinates are links without mass and
//! length in front of the base body (Fig. 1), so one recursion serves every base:
//!
//! | base | degrees of freedom before the joints |
//! |---|---|
//! | fixed | none: the base body is link 0 |
//! | planar | x, z, turn about y |
//! | virtual | x, y, z, turns about z, y, x, each axis carried by the turn before it |
//! | quaternion | x, y, z, turns about the world's x, y, z, whose axes the translating link 3 carries |
//!
//! With that choice of carrier the last three rates are the angular velocity in W and need no other case anywhere.

use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::spatial::Symmetric;
use crate::state::{self, State};
use messages::robot::{Body, JointKind};
use messages::scene::{Base, Scene};
use nalgebra::{Matrix3, Vector3};

/// How a link moves against its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Turns about the axis by the coordinate [rad].
    Revolute,
    /// Slides along the axis by the coordinate [m].
    Prismatic,
    /// Turns about an axis of W; the orientation is the base's quaternion, which all three such links share.
    Spin,
}

/// One link of the tree, with its joint to the parent.
#[derive(Clone, Debug)]
pub struct Link {
    /// Parent link, less than this link's own index.
    pub parent: usize,
    /// Link in which the joint's axis is fixed: the parent, but link 3 for the turns of a quaternion base.
    pub carrier: usize,
    /// Kind of motion.
    pub motion: Motion,
    /// Unit axis z in the carrier's frame.
    pub axis: Vector3<f64>,
    /// Joint in the parent's frame; this link's origin is there at zero travel [m].
    pub at: Vector3<f64>,
    /// Mass with payload; zero for virtual links [kg].
    pub mass: f64,
    /// Centre of mass in the link's frame [m].
    pub com: Vector3<f64>,
    /// Inertia about the centre of mass, in the link's axes [kg·m²].
    pub tensor: Symmetric,
    /// Drive inertia J_r on the joint; zero for virtual links [kg·m²].
    pub drive_inertia: f64,
    /// Viscous damping D of the joint; zero for virtual links [N·m·s/rad].
    pub damping: f64,
}

/// A point that may touch the ground.
#[derive(Clone, Debug, PartialEq)]
pub struct Corner {
    /// Link that carries it.
    pub link: usize,
    /// Where, in the link's frame [m].
    pub at: Vector3<f64>,
}

/// The robot and its gravity: everything constant that the dynamics need.
#[derive(Clone, Debug)]
pub struct Model {
    /// Coordinates of the base.
    pub base: Base,
    /// Acceleration of free fall in W [m/s²].
    pub gravity: Vector3<f64>,
    /// Orientation of link 0 in W: identity but for a fixed base.
    pub mount_rotation: Matrix3<f64>,
    /// Position of link 0 in W [m]: zero but for a fixed base, and for y of a planar one.
    pub mount_position: Vector3<f64>,
    /// The links, parents first.
    pub links: Vec<Link>,
    /// Link of the base body; also the number of degrees of freedom before the joints.
    pub base_link: usize,
    /// Link of each body of the scene, in the scene's order.
    pub body_link: Vec<usize>,
    /// Names of the bodies of the scene, likewise.
    pub body_name: Vec<String>,
    /// Degree of freedom of each joint, in the order of the scene's bodies that carry joints (wire order).
    pub joint_dof: Vec<usize>,
    /// Contact points, in the order of the scene's bodies.
    pub corners: Vec<Corner>,
    /// Degrees of freedom between W and each link, base first, one list after the other.
    path: Vec<usize>,
    /// Where the list of each link begins, and the end of the last.
    path_start: Vec<usize>,
}

impl Model {
    /// Builds the model of a scene's bodies, base, payload and gravity.
    ///
    /// Gravity is tilted by the incline so that downhill is +x: g (sin a, 0, -cos a).
    ///
    /// # Errors
    /// One sentence on a body, tree, payload or initial pose that cannot be simulated.
    pub fn new(scene: &Scene) -> Result<Model, PlantError> {
        let bodies = &scene.bodies;
        let order = depth_first(bodies)?;
        let tilt = scene.plant.incline_deg.to_radians();
        let mut links = vec![virtual_link(0, Motion::Prismatic, Vector3::zeros())];
        links.extend(virtual_links(scene.plant.base));
        let base_link = links.len() - 1;
        let mut body_link = vec![base_link; bodies.len()];
        for &(index, parent) in &order {
            let body = &bodies[index];
            if let Some(joint) = &body.joint {
                let parent = body_link[parent];
                body_link[index] = links.len();
                links.push(Link {
                    motion: match joint.kind {
                        JointKind::Revolute => Motion::Revolute,
                        JointKind::Prismatic => Motion::Prismatic,
                    },
                    at: finite(joint.at, || format!("the joint of body `{}`", body.name))?,
                    drive_inertia: not_negative(scene.plant.drive_inertia, "the drive inertia")?,
                    damping: not_negative(scene.plant.joint_damping, "the joint damping")?,
                    ..virtual_link(parent, Motion::Revolute, unit(joint.axis, &body.name)?)
                });
            }
            fill(&mut links[body_link[index]], body)?;
        }
        load(&mut links, scene, &body_link, base_link)?;

        let (mut path, mut path_start) = (vec![], vec![0]);
        for (i, link) in links.iter().enumerate() {
            let start = path.len();
            if i > 0 {
                path.extend_from_within(path_start[link.parent]..path_start[link.parent + 1]);
                path.push(i - 1);
            }
            path_start.push(path.len());
            debug_assert!(start <= path.len());
        }
        let jointed = |&(index, _): &(usize, &Body)| bodies[index].joint.is_some();
        let corner = |link: usize, at: &[f64; 3], body: &Body| {
            finite(*at, || format!("a contact point of body `{}`", body.name)).map(|at| Corner { link, at })
        };
        let mut model = Model {
            base: scene.plant.base,
            gravity: Vector3::new(tilt.sin(), 0.0, -tilt.cos()) * not_negative(scene.plant.gravity, "gravity")?,
            mount_rotation: Matrix3::identity(),
            mount_position: Vector3::zeros(),
            base_link,
            joint_dof: bodies.iter().enumerate().filter(jointed).map(|(index, _)| body_link[index] - 1).collect(),
            corners: bodies
                .iter()
                .zip(&body_link)
                .flat_map(|(body, &link)| body.contacts.iter().map(move |at| corner(link, at, body)))
                .collect::<Result<_, _>>()?,
            body_name: bodies.iter().map(|body| body.name.clone()).collect(),
            links,
            body_link,
            path,
            path_start,
        };
        model.mount(scene)?;
        Ok(model)
    }

    /// Puts link 0 where the scene's initial pose wants it and the base's coordinates cannot take it.
    fn mount(&mut self, scene: &Scene) -> Result<(), PlantError> {
        let position = finite(scene.initial.position, || "the initial position".into())?;
        match self.base {
            Base::Fixed => {
                self.mount_rotation = state::orientation(&scene.initial)?;
                self.mount_position = position;
                if let Some(clearance) = scene.initial.clearance {
                    let mut pose = Pose::new(self);
                    kinematics::pose(self, &State::initial(self, &scene.initial)?, &mut pose);
                    self.mount_position.z += state::lift(self, &pose, clearance)?;
                }
            }
            Base::Planar => self.mount_position.y = position.y,
            Base::Virtual | Base::Quaternion => {}
        }
        Ok(())
    }

    /// Number of degrees of freedom, the length of xdot.
    pub fn dofs(&self) -> usize {
        self.links.len() - 1
    }

    /// Length of x: one more than [`Model::dofs`] with a quaternion base.
    pub fn coordinates(&self) -> usize {
        self.dofs() + usize::from(self.base == Base::Quaternion)
    }

    /// Degrees of freedom between W and a link, base first: the only ones that move it.
    #[inline]
    pub fn path(&self, link: usize) -> &[usize] {
        &self.path[self.path_start[link]..self.path_start[link + 1]]
    }

    /// Number of degrees of freedom between W and a link.
    #[inline]
    pub fn depth(&self, link: usize) -> usize {
        self.path_start[link + 1] - self.path_start[link]
    }

    /// Number of degrees of freedom that two links share: their paths agree up to there.
    pub fn shared(&self, a: usize, b: usize) -> usize {
        self.path(a).iter().zip(self.path(b)).take_while(|(i, j)| i == j).count()
    }

    /// Total mass [kg].
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|link| link.mass).sum()
    }

    /// Link of the body with this name; the base's for an empty name.
    ///
    /// # Errors
    /// [`PlantError::Unknown`], `what` telling who asks.
    pub fn link_of(&self, name: &str, what: &str) -> Result<usize, PlantError> {
        if name.is_empty() {
            return Ok(self.base_link);
        }
        let index = self.body_name.iter().position(|known| known == name);
        index.map(|index| self.body_link[index]).ok_or_else(|| unknown(what, name, &self.body_name.join(", ")))
    }
}

fn unknown(what: &str, name: &str, known: &str) -> PlantError {
    PlantError::Unknown { what: what.into(), name: name.into(), known: known.into() }
}

/// Bodies with their parents' indices, each parent before its children and each branch in one piece.
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
        at: Vector3::zeros(),
        mass: 0.0,
        com: Vector3::zeros(),
        tensor: Symmetric::default(),
        drive_inertia: 0.0,
        damping: 0.0,
    }
}

/// The links of Fig. 1 that stand for the base's coordinates.
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

/// Gives a link the mass of its body.
fn fill(link: &mut Link, body: &Body) -> Result<(), PlantError> {
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
    link.tensor = Symmetric([moments[0], moments[1], moments[2], 0.0, 0.0, 0.0]);
    Ok(())
}

/// Adds the scene's payload, a point mass, to the link of its body.
fn load(links: &mut [Link], scene: &Scene, body_link: &[usize], base_link: usize) -> Result<(), PlantError> {
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
    let com = (link.com * link.mass + offset * mass) / total;
    link.tensor = link.tensor
        + Symmetric::of_point(link.mass, &(link.com - com))
        + Symmetric::of_point(mass, &(offset - com));
    (link.mass, link.com) = (total, com);
    Ok(())
}

fn unit(axis: [f64; 3], body: &str) -> Result<Vector3<f64>, PlantError> {
    let rule = || PlantError::value(format!("the joint axis of body `{body}`"), axis, "a direction, not zero");
    Vector3::from(axis).try_normalize(1e-12).filter(|axis| axis.iter().all(|c| c.is_finite())).ok_or_else(rule)
}

pub(crate) fn finite(value: [f64; 3], what: impl Fn() -> String) -> Result<Vector3<f64>, PlantError> {
    let good = value.iter().all(|component| component.is_finite());
    if good { Ok(value.into()) } else { Err(PlantError::value(what(), value, "finite")) }
}

fn not_negative(value: f64, what: &str) -> Result<f64, PlantError> {
    let good = value >= 0.0 && value.is_finite();
    if good { Ok(value) } else { Err(PlantError::value(what, value, "finite and not negative")) }
}
