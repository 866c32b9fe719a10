//! Fast H and b: composite rigid bodies for H, and one recursion for b. A step uses this module, not [`crate::dynamics`].
//!
//! The results equal those of [`crate::dynamics`] to rounding. All quantities are about O in W axes, so inertias and wrenches of a branch
//! add up towards the base.
//!
//! # Source
//! Featherstone, Rigid Body Dynamics Algorithms (2008), ch. 5 and 6; the equations are (1)-(11).

use crate::factor::PathMatrix;
use crate::kinematics::Pose;
use crate::model::{ContactPoint, Model, Motion};
use crate::spatial::{Inertia, Spatial};
use nalgebra::Vector3;

/// Workspace of the recursions, one entry per link.
#[derive(Clone, Debug)]
pub struct Composite {
    inertia: Vec<Inertia>,
    acceleration: Vec<Spatial>,
    wrench: Vec<Spatial>,
}

impl Composite {
    /// Allocates for a model.
    pub fn new(model: &Model) -> Self {
        let links = model.links.len();
        Composite {
            inertia: vec![Inertia::default(); links],
            acceleration: vec![Spatial::default(); links],
            wrench: vec![Spatial::default(); links],
        }
    }

    /// H and b of (1) in a state with this pose; allocates.
    pub fn equations(model: &Model, pose: &Pose, xdot: &[f64]) -> (PathMatrix, Vec<f64>) {
        let (mut composite, mut h, mut b) = (Composite::new(model), PathMatrix::new(model), vec![0.0; model.dofs()]);
        composite.inertia(model, pose, &mut h);
        composite.bias(model, pose, xdot, &mut b);
        (h, b)
    }

    /// H(x) of (1), with J_r on the diagonal.
    ///
    /// H_ij = S_j · I_i S_i for each j on the path to link i, where I_i is the inertia of the whole branch of link i.
    pub fn inertia(&mut self, model: &Model, pose: &Pose, h: &mut PathMatrix) {
        let aligned = model.world_aligned();
        // of the world-aligned links only the last has mass
        let links = model.links[aligned..].iter().zip(&pose.links[aligned..]);
        for (sum, (link, pose)) in self.inertia[aligned..].iter_mut().zip(links) {
            *sum = if link.mass > 0.0 { Inertia::new(link.mass, &pose.com, &pose.tensor) } else { Inertia::default() };
        }
        for i in (1 + aligned..model.links.len()).rev() {
            let link = &model.links[i];
            let carried = self.inertia[i];
            self.inertia[link.parent] += carried;
            self.wrench[i] = carried.times(&pose.links[i].column);
        }
        if aligned > 0 {
            let all = self.inertia[aligned]; // of the whole robot
            self.wrench[1..].iter_mut().zip(all.columns()).take(aligned).for_each(|(wrench, column)| *wrench = column);
            self.wrench[1..].iter().enumerate().for_each(|(i, wrench)| h.set_first(i, wrench));
        }
        for (j, link) in model.links[1..].iter().enumerate().skip(aligned) {
            let Spatial { angular, linear } = pose.links[j + 1].column;
            let wrenches = self.wrench[1..][model.branch(j)].iter();
            // a virtual link slides, or turns about O, so half of its column is zero
            match (j < model.base_link, link.motion) {
                (true, Motion::Prismatic) => h.set_column(model, j, wrenches.map(|f| linear.dot(&f.linear))),
                (true, _) => h.set_column(model, j, wrenches.map(|f| angular.dot(&f.angular))),
                (false, _) => {
                    h.set_column(model, j, wrenches.map(|f| angular.dot(&f.angular) + linear.dot(&f.linear)));
                }
            }
            h.add_diagonal(j, link.drive_inertia);
        }
    }

    /// b(x, xdot) of (1): Coriolis, centrifugal and gravity effects, and the damping D xdot.
    ///
    /// `xdot` must be the rates that `pose` was computed with.
    pub fn bias(&mut self, model: &Model, pose: &Pose, xdot: &[f64], b: &mut [f64]) {
        let aligned = model.world_aligned();
        for (i, link) in model.links.iter().enumerate().skip(aligned) {
            let here = &pose.links[i];
            let a = if i == aligned {
                // gravity acts as an upward acceleration of link 0, as in the paper; sliding links move the axes of the turning ones
                let Spatial { angular: w, linear: v } = here.velocity;
                Spatial { angular: Vector3::zeros(), linear: v.cross(&w) - model.gravity }
            } else {
                let swept = pose.links[link.carrier].velocity.cross(&(here.column * xdot[i - 1]));
                self.acceleration[link.parent] + swept
            };
            self.acceleration[i] = a;
            self.wrench[i] = if link.mass > 0.0 {
                let w = here.velocity.angular;
                let velocity = here.velocity.at(&here.com);
                let force = (a.at(&here.com) + w.cross(&velocity)) * link.mass;
                let moment = &here.tensor * &a.angular + w.cross(&(&here.tensor * &w));
                Spatial { angular: moment + here.com.cross(&force), linear: force }
            } else {
                Spatial::default()
            };
        }
        for i in (aligned + 1..model.links.len()).rev() {
            let link = &model.links[i];
            let wrench = self.wrench[i];
            b[i - 1] = pose.links[i].column.dot(&wrench) + link.damping * xdot[i - 1];
            self.wrench[link.parent] += wrench;
        }
        let Spatial { linear: f, angular: n } = self.wrench[aligned];
        b.iter_mut().zip([f.x, f.y, f.z, n.x, n.y, n.z]).take(aligned).for_each(|(b, sum)| *b = sum);
    }

    /// K̇ᵀẋ: the acceleration of a contact point in W at ẍ = 0 [m/s²], after [`Composite::bias`] at this pose. The contact point of a ball
    /// is always below its centre.
    pub fn bias_acceleration(&self, model: &Model, pose: &Pose, point: &ContactPoint) -> Vector3<f64> {
        let (velocity, acceleration) = (&pose.links[point.link].velocity, &self.acceleration[point.link]);
        let centre = pose.arm(point.link, &point.at);
        let down = Vector3::new(0.0, 0.0, -point.radius);
        let of_centre = acceleration.at(&centre) + velocity.angular.cross(&velocity.at(&centre)) + model.gravity;
        of_centre + acceleration.angular.cross(&down)
    }
}
