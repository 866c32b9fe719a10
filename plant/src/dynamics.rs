//! The paper's inverse dynamics (2)-(11) in its order and notation; H, b and K of (1) from it.
//!
//! This is the readable reference. A step uses [`crate::composite`], and tests compare the two. Differences from the printed equations:
//!
//! - A link of a tree has one joint towards the base and any number away from it. So p_i is the origin of link i *at joint i*, which the
//!   paper calls p_{i-1}, and p_i* = p_i - p_{i-1} is fixed in the parent: (5) uses the velocities of the parent.
//! - Prismatic joints follow Luh, Walker & Paul (1980); the base position has such joints too.
//! - (8) lacks link indices: it is J_i wd_i + w_i × J_i w_i.
//! - (9) has f_EXT as the force of link on ground. Then (1) would hold with -K, and an impulse that is positive by (15) would pull. Here
//!   f_EXT acts *on* the link and is subtracted.
//! - (10) as printed adds (p_{i-1} - r_i) × f_i. The moment equation about r_i has it on the other side, so it is subtracted. (10) also
//!   lacks the moment of f_EXT. Here it is included; otherwise K would lack the lever arms of the feet.
//! - (11) subtracts D_i qd_i, which in (1) would be a damping that adds energy. Here it is added, and so is J_r qdd_i.
//!
//! tests/dynamics/errata.rs shows each of these against data of other engines.

use crate::kinematics::Pose;
use crate::model::{Model, Motion};
use nalgebra::{DMatrix, DVector, Vector3};

/// A force on a link.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Force {
    /// The link that it acts on.
    pub link: usize,
    /// Point of attack, from the reference point O of the pose, W axes [m].
    pub arm: Vector3<f64>,
    /// The force u_j f_EXTj on the link, in W [N].
    pub force: Vector3<f64>,
}

/// Input of inverse dynamics besides the pose.
#[derive(Clone, Copy, Debug)]
pub struct Given<'a> {
    /// xdot [m/s, rad/s].
    pub rate: &'a [f64],
    /// xddot [m/s², rad/s²].
    pub acceleration: &'a [f64],
    /// Acceleration of free fall [m/s²].
    pub gravity: Vector3<f64>,
    /// External forces.
    pub forces: &'a [Force],
}

/// u = H xddot + b - K f_EXT: the effort on each degree of freedom for a given motion. Allocates.
///
/// # Source
/// (2)-(11), with the corrections at the top of this file.
pub fn inverse(model: &Model, pose: &Pose, given: &Given) -> Vec<f64> {
    let links = model.links.len();
    let zero = vec![Vector3::zeros(); links];
    let (mut w, mut wd, mut pdd, mut force, mut moment) =
        (zero.clone(), zero.clone(), zero.clone(), zero.clone(), zero.clone());
    // (2) w_0 = wd_0 = 0; gravity as an acceleration of link 0
    pdd[0] = -given.gravity;
    for i in 1..links {
        let (link, parent) = (&model.links[i], model.links[i].parent);
        let (qd, qdd) = (given.rate[i - 1], given.acceleration[i - 1]);
        let z = axis(pose, link.motion, i);
        let p = pose.links[i].origin - pose.links[parent].origin;
        let carried = w[link.carrier].cross(&(z * qd));
        (w[i], wd[i]) = (w[parent], wd[parent]);
        pdd[i] = wd[parent].cross(&p) + w[parent].cross(&w[parent].cross(&p)) + pdd[parent]; // (5)
        match link.motion {
            Motion::Revolute | Motion::Spin => {
                w[i] += z * qd; // (3)
                wd[i] += z * qdd + carried; // (4)
            }
            Motion::Prismatic => pdd[i] += z * qdd + carried * 2.0,
        }
    }
    let mut u = vec![0.0; links - 1];
    for i in (0..links).rev() {
        let (link, here) = (&model.links[i], &pose.links[i]);
        let (r, tensor) = (here.com, here.tensor.matrix());
        let s = r - here.origin;
        let rdd = wd[i].cross(&s) + w[i].cross(&w[i].cross(&s)) + pdd[i]; // (6)
        // here force[i], moment[i] hold the sums of f and n + (p - r_i) × f over the children
        force[i] += rdd * link.mass; // (7), (9)
        moment[i] += tensor * wd[i] + w[i].cross(&(tensor * w[i])); // (8), (10)
        for external in given.forces.iter().filter(|external| external.link == i) {
            force[i] -= external.force; // (9)
            moment[i] -= (external.arm - r).cross(&external.force); // (10)
        }
        let (f, p) = (force[i], here.origin);
        let n = moment[i] - (p - r).cross(&f); // (10)
        if i == 0 {
            break;
        }
        let (qd, qdd) = (given.rate[i - 1], given.acceleration[i - 1]);
        let z = axis(pose, link.motion, i);
        let along = match link.motion {
            Motion::Revolute | Motion::Spin => z.dot(&n),
            Motion::Prismatic => z.dot(&f),
        };
        u[i - 1] = along + link.damping * qd + link.drive_inertia * qdd; // (11)
        force[link.parent] += f;
        moment[link.parent] += n + (p - pose.links[link.parent].com).cross(&f);
    }
    u
}

/// Axis of joint i in W.
fn axis(pose: &Pose, motion: Motion, i: usize) -> Vector3<f64> {
    let column = &pose.links[i].column;
    match motion {
        Motion::Revolute | Motion::Spin => column.angular,
        Motion::Prismatic => column.linear,
    }
}

/// H(x): column j is the effort of xddot = e_j without velocity, gravity and external forces. Allocates.
pub fn inertia(model: &Model, pose: &Pose) -> DMatrix<f64> {
    let rest = vec![0.0; model.dofs()];
    let mut h = DMatrix::zeros(model.dofs(), model.dofs());
    for j in 0..model.dofs() {
        let mut unit = rest.clone();
        unit[j] = 1.0;
        let given = Given { rate: &rest, acceleration: &unit, gravity: Vector3::zeros(), forces: &[] };
        h.set_column(j, &DVector::from_vec(inverse(model, pose, &given)));
    }
    h
}

/// b(x, xdot): the effort of xddot = 0. Allocates.
pub fn bias(model: &Model, pose: &Pose, xdot: &[f64]) -> Vec<f64> {
    let acceleration = vec![0.0; model.dofs()];
    inverse(model, pose, &Given { rate: xdot, acceleration: &acceleration, gravity: model.gravity, forces: &[] })
}

/// A column of K(x): minus the effort that holds the robot still against one external force. Allocates.
pub fn contact_column(model: &Model, pose: &Pose, force: Force) -> Vec<f64> {
    let rest = vec![0.0; model.dofs()];
    let given = Given { rate: &rest, acceleration: &rest, gravity: Vector3::zeros(), forces: &[force] };
    inverse(model, pose, &given).into_iter().map(|effort| -effort).collect()
}
