//! The contact problem of a step, (12)-(14): K, A = KᵀH⁻¹K and b = Kᵀ(ẋ₋ + H⁻¹Δf_b).

use crate::contact::{Problem, follows_slip, tangents};
use crate::detect::Touch;
use crate::factor::Factor;
use crate::kinematics::{Pose, contact_column};
use crate::model::Model;
use messages::scene::Law;
use nalgebra::Vector3;

/// Cosine of the angle, 8°, within which contacts share one direction of slip.
const NEARLY: f64 = 0.99;

/// K and Y = L⁻ᵀK, one row per contact row: entries on the path to the contact's link, base first, the rest unused.
#[derive(Clone, Debug)]
pub struct ContactMap {
    half: Vec<f64>,
    /// Y of unit impulses along x, y and z at one contact.
    axes: Vec<f64>,
    column: Vec<f64>,
    stride: usize,
    /// Unit tangents of each contact.
    tangents: Vec<[Vector3<f64>; 2]>,
}

impl ContactMap {
    /// Room for a model.
    pub fn new(model: &Model) -> Self {
        let stride = model.dofs();
        let rows = 3 * model.corners.len();
        ContactMap {
            half: vec![0.0; rows * stride],
            axes: vec![0.0; 3 * stride],
            column: vec![0.0; stride],
            stride,
            tangents: Vec::with_capacity(model.corners.len()),
        }
    }

    /// Writes the problem of the touching contacts. `free` is the velocity that the step would end with if nothing
    /// touched, ẋ₋ + H⁻¹Δf_b.
    ///
    /// The first tangent of a contact is its direction of free slip, so that friction can oppose it exactly. The paper
    /// takes the velocity before the step; a contact at rest has none, and would creep down any slope.
    #[expect(clippy::too_many_arguments, reason = "one stage of the step: model, pose and factor are its tools")]
    pub fn assemble(
        &mut self,
        model: &Model,
        pose: &Pose,
        factor: &Factor,
        touches: &[Touch],
        free: &[f64],
        law: Law,
        problem: &mut Problem,
    ) {
        let tangents = tangents(law);
        problem.reset(touches.len(), tangents);
        self.tangents.clear();
        let rows = 1 + tangents;
        for (i, touch) in touches.iter().enumerate() {
            let path = model.path(touch.link);
            let mut drift = Vector3::zeros();
            for (axis, half) in self.axes.chunks_exact_mut(self.stride).enumerate() {
                let half = &mut half[..path.len()];
                let mut direction = Vector3::zeros();
                direction[axis] = 1.0;
                contact_column(model, pose, touch.link, &touch.arm, &direction, half);
                drift[axis] = half.iter().zip(path).map(|(k, &dof)| k * free[dof]).sum();
                factor.half_solve(model, touch.link, half);
            }
            let slip = drift.xy().norm();
            let along = if slip > 0.0 && follows_slip(law) {
                Vector3::new(drift.x / slip, drift.y / slip, 0.0)
            } else {
                Vector3::x()
            };
            let along = self.near_before(i, along); // the same for fixed axes
            let across = Vector3::new(-along.y, along.x, 0.0);
            self.tangents.push([along, across]);
            problem.id[i] = touch.id;
            let (x, rest) = self.axes.split_at(self.stride);
            let (y, z) = rest.split_at(self.stride);
            for (k, row) in self.half[i * rows * self.stride..].chunks_exact_mut(self.stride).take(rows).enumerate() {
                match k {
                    0 => row.copy_from_slice(z),
                    _ => {
                        let t = self.tangents[i][k - 1];
                        row.iter_mut().zip(x.iter().zip(y)).for_each(|(out, (x, y))| *out = t.x * x + t.y * y);
                    }
                }
            }
            let drift = [drift.z, drift.dot(&along), drift.dot(&across)];
            problem.drift[i * rows..(i + 1) * rows].copy_from_slice(&drift[..rows]);
        }
        self.multiply(model, touches, problem);
    }

    /// The tangent of the contact before, if this one's is nearly parallel to it.
    ///
    /// The corners of a foot slip alike. Friction cones that differ by a hair would let them chase each other along
    /// directions in which the feet hardly move, and the problem would be as ill-conditioned as the hair is thin.
    fn near_before(&self, i: usize, along: Vector3<f64>) -> Vector3<f64> {
        match i.checked_sub(1).map(|before| self.tangents[before][0]) {
            Some(before) if before.dot(&along).abs() > NEARLY => before * before.dot(&along).signum(),
            _ => along,
        }
    }

    /// A = YᵀY: two contacts meet in the degrees of freedom that their links share.
    fn multiply(&self, model: &Model, touches: &[Touch], problem: &mut Problem) {
        let (rows, size) = (1 + problem.tangents, problem.rows());
        for (i, a) in touches.iter().enumerate() {
            for (j, b) in touches.iter().enumerate().take(i + 1) {
                let shared = model.shared(a.link, b.link);
                for k in i * rows..(i + 1) * rows {
                    let y_k = &self.half[k * self.stride..][..shared];
                    for l in j * rows..((j + 1) * rows).min(k + 1) {
                        let y_l = &self.half[l * self.stride..][..shared];
                        let product = y_k.iter().zip(y_l).map(|(a, b)| a * b).sum();
                        problem.delassus[k * size + l] = product;
                        problem.delassus[l * size + k] = product;
                    }
                }
            }
        }
    }

    /// K Δf, added to `effort`: what the contact impulses do to each degree of freedom [N·s, N·m·s].
    pub fn push(&mut self, model: &Model, pose: &Pose, touches: &[Touch], impulse: &[f64], effort: &mut [f64]) {
        for (i, touch) in touches.iter().enumerate() {
            let force = self.force(i, impulse, touches.len());
            contact_column(model, pose, touch.link, &touch.arm, &force, &mut self.column);
            for (k, &dof) in self.column.iter().zip(model.path(touch.link)) {
                effort[dof] += k;
            }
        }
    }

    /// Impulse on the i-th of `contacts` contacts as a vector in W [N·s].
    pub fn force(&self, i: usize, impulse: &[f64], contacts: usize) -> Vector3<f64> {
        let rows = impulse.len() / contacts;
        let parts = &impulse[i * rows..(i + 1) * rows];
        parts[1..].iter().zip(&self.tangents[i]).fold(Vector3::z() * parts[0], |sum, (f, t)| sum + t * *f)
    }
}
