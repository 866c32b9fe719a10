//! The robot model of the dynamics: a tree of links with one degree of freedom each, constant after construction.
//!
//! Link 0 is the paper's "virtual base link", fixed in W. Link i > 0 moves relative to its parent by the degree of freedom i - 1. Parents
//! come before children, and each branch is contiguous. The coordinates of the base are links without mass and length in front of the base
//! body (Fig. 1). So one recursion serves every kind of base:
//!
//! | base | degrees of freedom before the joints |
//! |---|---|
//! | fixed | none: the base body is link 0 |
//! | planar | x, z, rotation about y |
//! | virtual | x, y, z, rotations about z, y, x, each axis carried by the rotation before it |
//! | quaternion | x, y, z, rotations about the world's x, y, z, whose axes the translating link 3 carries |
//!
//! With the last choice of carrier, the last three rates are the angular velocity in W, and no other code needs a special case.

pub(crate) mod build;
mod check;
mod contact_points;

pub(crate) use check::finite;

use crate::error::PlantError;
use messages::robot::Tiles;
use messages::scene::{Base, Ground};
use nalgebra::{Matrix3, Vector3};
use std::ops::Range;

/// How a link moves relative to its parent.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Motion {
    /// Rotation about the axis by the coordinate [rad].
    Revolute,
    /// Translation along the axis by the coordinate [m].
    Prismatic,
    /// Rotation about an axis of W. The orientation is the quaternion of the base, which all three such links share.
    Spin,
}

/// One link of the tree, with its joint to the parent.
#[derive(Clone, Debug)]
pub struct Link {
    /// Parent link, less than this link's own index.
    pub parent: usize,
    /// Link in which the joint's axis is fixed: the parent, or link 3 for the rotations of a quaternion base.
    pub carrier: usize,
    /// Kind of motion.
    pub motion: Motion,
    /// Unit axis z in the carrier's frame.
    pub axis: Vector3<f64>,
    /// Index of the carrier's coordinate axis that is parallel to the axis, if any; rotation about it is cheaper.
    pub along: Option<usize>,
    /// Position of the joint in the parent's frame; the link's origin at zero coordinate [m].
    pub at: Vector3<f64>,
    /// Mass with payload; zero for virtual links [kg].
    pub mass: f64,
    /// Centre of mass in the link's frame [m].
    pub com: Vector3<f64>,
    /// Principal moments of the body alone, along the link's axes [kg·m²].
    pub moments: Vector3<f64>,
    /// Point mass that adds the payload's part of the moments, m_1 m_2/(m_1 + m_2) [kg].
    pub reduced_mass: f64,
    /// Position of that point mass relative to the body's own centre of mass, in the link's frame [m].
    pub payload_arm: Vector3<f64>,
    /// Drive inertia J_r on the joint; zero for virtual links [kg·m²].
    pub drive_inertia: f64,
    /// Viscous damping D of the joint; zero for virtual links [N·m·s/rad].
    pub damping: f64,
}

/// A contact point, or a ball that touches with its lowest point.
#[derive(Clone, Debug, PartialEq)]
pub struct ContactPoint {
    /// Link that carries it.
    pub link: usize,
    /// Position of the point, or of the ball's centre, in the link's frame [m].
    pub at: Vector3<f64>,
    /// Radius; zero for a point [m].
    pub radius: f64,
    /// Where there is ground for it; everywhere if none.
    pub tiles: Option<Tiles>,
    /// Whether a degree of freedom moves it. Nothing determines the force on a point that does not move, so such a point never touches.
    pub moves: bool,
}

impl ContactPoint {
    /// Whether it moves, and there is ground below it if it is at x [m].
    #[inline]
    pub fn may_touch(&self, x: f64) -> bool {
        self.moves && self.tiles.is_none_or(|tiles| tiles.has_ground_at(x))
    }
}

/// A spring and damper on a joint, with torque k (q0 - q) - d q'.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spring {
    /// Degree of freedom of the joint.
    pub dof: usize,
    /// k [N·m/rad or N/m].
    pub stiffness: f64,
    /// d, the D of (1) for this joint [N·m·s/rad or N·s/m].
    pub damping: f64,
    /// q0 [rad or m].
    pub rest: f64,
    /// H_ii (H⁻¹)_ii at the initial pose: the inertia of the joint with all others held, over that with all others free [-]. To compute it in
    /// every step would take a second factor of H. It is rounded down to a power of ten. The smallest model of a scene has fewer degrees of
    /// freedom, so its exact coupling differs a little, but its rounded coupling must be the same.
    pub coupling: f64,
}

/// The robot, gravity and the ground: all constants of the dynamics.
#[derive(Clone, Debug)]
pub struct Model {
    /// Heights of the ground; `None` if it is the plane z = 0.
    pub ground: Option<Ground>,
    /// Coordinates of the base.
    pub base: Base,
    /// Acceleration of free fall in W [m/s²].
    pub gravity: Vector3<f64>,
    /// Orientation of link 0 in W: the identity, except for a fixed base.
    pub mount_rotation: Matrix3<f64>,
    /// Position of link 0 in W [m]: zero, except for a fixed base, and for y of a planar one.
    pub mount_position: Vector3<f64>,
    /// The links, parents first.
    pub links: Vec<Link>,
    /// Link of the base body; also the number of degrees of freedom before the joints. The frame of a movable base is at its centre of mass.
    pub base_link: usize,
    /// Origin of the frame that the scene gives the base, in the frame of its link [m].
    pub base_frame: Vector3<f64>,
    /// Link of each body of the scene, in the scene's order.
    pub body_link: Vec<usize>,
    /// Names of the bodies, in the scene's order.
    pub body_name: Vec<String>,
    /// Degree of freedom of each joint, in the order of the scene's bodies that carry joints (wire order).
    pub joint_dof: Vec<usize>,
    /// Contact points and balls, in the order of the scene's bodies.
    pub contact_points: Vec<ContactPoint>,
    /// Whether more than two links have contacts. They could share the load in many ways, as the wheels of a cart do.
    pub shares_load: bool,
    /// Scale of lengths: the greatest distance of a joint or a contact from the centre of mass of a body that it belongs to [m]. It does
    /// not depend on the bodies' frames.
    pub length: f64,
    /// Tangents with friction at most: one, x, if nothing moves along y.
    pub directions: usize,
    /// Springs and dampers of the scene's joints; empty if there are none.
    pub springs: Vec<Spring>,
    /// Degrees of freedom between W and each link, base first, one list after the other.
    path: Vec<usize>,
    /// Start of each link's list, and the end of the last list.
    path_start: Vec<usize>,
    /// End of the branch of each degree of freedom.
    branch_end: Vec<usize>,
}

impl Model {
    /// Number of degrees of freedom, the length of xdot.
    pub fn dofs(&self) -> usize {
        self.links.len() - 1
    }

    /// Length of x: one more than [`Model::dofs`] with a quaternion base.
    pub fn coordinates(&self) -> usize {
        self.dofs() + usize::from(self.base == Base::Quaternion)
    }

    /// Number of first degrees of freedom that are along, and then about, the axes of W.
    #[inline]
    pub fn world_aligned(&self) -> usize {
        match self.base {
            Base::Fixed | Base::Planar => 0,
            Base::Virtual => 3,
            Base::Quaternion => 6,
        }
    }

    /// Degrees of freedom between W and a link, base first. No other degree of freedom moves the link.
    #[inline]
    pub fn path(&self, link: usize) -> &[usize] {
        &self.path[self.path_start[link]..self.path_start[link + 1]]
    }

    /// Range of the degrees of freedom of the branch that starts with i.
    #[inline]
    pub fn branch(&self, i: usize) -> Range<usize> {
        i..self.branch_end[i]
    }

    /// Number of degrees of freedom between W and a link.
    #[inline]
    pub fn depth(&self, link: usize) -> usize {
        self.path_start[link + 1] - self.path_start[link]
    }

    /// Number of degrees of freedom that two links share. Their paths agree up to there.
    pub fn shared(&self, a: usize, b: usize) -> usize {
        self.path(a).iter().zip(self.path(b)).take_while(|(i, j)| i == j).count()
    }

    /// Whether the base has six degrees of freedom, so that every link can move in all directions.
    pub fn has_floating_base(&self) -> bool {
        matches!(self.base, Base::Virtual | Base::Quaternion)
    }

    /// Whether a joint has a spring; dampers alone do not count.
    pub fn has_springs(&self) -> bool {
        self.springs.iter().any(|spring| spring.stiffness > 0.0)
    }

    /// Whether a joint has a damper.
    pub fn has_dampers(&self) -> bool {
        self.springs.iter().any(|spring| spring.damping > 0.0)
    }

    /// Height of the ground at a place in W [m].
    pub fn ground_at(&self, place: &Vector3<f64>) -> f64 {
        self.ground.as_ref().map_or(0.0, |ground| ground.height(place.x, place.y))
    }

    /// Total mass [kg].
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|link| link.mass).sum()
    }

    /// Link of the body with this name; the base's link for an empty name.
    ///
    /// # Errors
    /// [`PlantError::Unknown`]; `what` is the key or option that refers to the name.
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
