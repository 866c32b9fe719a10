//! Distribution of a wrench over the contacts of a sole: normal impulses linear over the sole, friction in proportion to them.
//!
//! Contacts at d_i from c, with q_i = (1, x_i, y_i), carry
//!
//! ```text
//!   n_i = q_i·N⁻¹(F_z, -m_y, m_x),   N = Σ q_i q_iᵀ
//!   f_i = n_i (s + γ z × (d_i − r)), s = F/F_z, γ = (m_z − r × F)/Σ n_i|d_i − r|²
//! ```
//!
//! where r is the centre of pressure. Of all normal impulses with that load, these have the least norm. A contact that would pull is left
//! out. Contacts on one line do not hold the link against rotation about that line, and a single contact holds no rotation at all. About
//! these free axes there is no moment and no unknown, and N⁻¹ is the pseudoinverse.
//!
//! No contact slips, so the impulses obey Coulomb's law wherever |f_F| <= μ f_N.

use super::spatial_pair::SpatialPair;
use crate::contact::{COLLINEAR, OVERREDUCTION, PULL_ROUNDING};
use crate::detect::Touch;
use nalgebra::{Matrix3, Vector2, Vector3};

/// Trials of the friction weights at most.
const MAX_TRIALS: usize = 8;

/// The contacts of a link, relative to a point amid them.
#[derive(Clone, Debug, Default)]
pub(super) struct Sole {
    /// c, from O [m].
    pub centre: Vector3<f64>,
    /// d_i [m].
    pub arms: Vec<Vector3<f64>>,
    /// Greatest |d_i| [m].
    pub reach: f64,
    /// N⁻¹ of all contacts.
    moment_inverse: Matrix3<f64>,
    /// Projection on the free axes, about which the contacts do not hold the link; zero unless they are on one line.
    pub free_axes: Matrix3<f64>,
    /// For each contact: normal impulse, friction weight, and friction impulse.
    pressure: Vec<f64>,
    weights: Vec<f64>,
    friction_forces: Vec<Vector2<f64>>,
}

impl Sole {
    /// Allocates for this many contacts.
    pub fn new(contacts: usize) -> Sole {
        Sole {
            arms: Vec::with_capacity(contacts),
            pressure: Vec::with_capacity(contacts),
            weights: Vec::with_capacity(contacts),
            friction_forces: Vec::with_capacity(contacts),
            ..Sole::default()
        }
    }

    /// Sets the contacts of a link.
    pub fn set(&mut self, touches: &[Touch]) {
        self.centre = touches.iter().map(|touch| touch.arm).sum::<Vector3<f64>>() / touches.len() as f64;
        self.centre.z = touches[0].arm.z; // all contacts are at the height of the ground
        self.arms.clear();
        self.arms.extend(touches.iter().map(|touch| touch.arm - self.centre));
        self.free_axes = match &self.arms[..] {
            [_] => Matrix3::identity(),
            [d, _] => d.normalize() * d.normalize().transpose(),
            _ => Matrix3::zeros(),
        };
    }

    /// Prepares the sole to carry a wrench; `None` if three or more contacts are on one line.
    pub fn prepare(&mut self) -> Option<()> {
        self.reach = self.arms.iter().fold(0.0, |reach: f64, d| reach.max(d.norm_squared())).sqrt();
        self.moment_inverse = match &self.arms[..] {
            [_] => Matrix3::from_diagonal(&Vector3::x()),
            [d, _] => {
                let (up, along) = (Vector3::x(), Vector3::new(0.0, d.x, d.y));
                0.5 * (up * up.transpose() + along * along.transpose() / along.norm_squared().powi(2))
            }
            arms => inverse_moment_matrix(arms.iter())?,
        };
        Some(())
    }

    /// Compliance of the sole to force and moment if each contact has this compliance: N⁻¹ for normal forces, 1/Σ1 and 1/Σ|d|² for
    /// friction. It is one along free axes.
    pub fn compliance(&self, relative_compliance: f64) -> [Matrix3<f64>; 2] {
        let (n, s) = (self.arms.len() as f64, &self.moment_inverse);
        let angular = self.arms.iter().map(|d| d.xy().norm_squared()).sum::<f64>();
        let force = Matrix3::from_diagonal(&Vector3::new(1.0 / n, 1.0 / n, s[(0, 0)]));
        let twist = if angular > 0.0 { 1.0 / angular } else { 0.0 };
        let moment = Matrix3::new(s[(2, 2)], -s[(1, 2)], 0.0, -s[(1, 2)], s[(1, 1)], 0.0, 0.0, 0.0, twist);
        [force * relative_compliance, moment * relative_compliance + self.free_axes]
    }

    /// The velocity that moves every contact downward by its allowed approach; zero otherwise.
    pub fn closing_velocity(&self, touches: &[Touch], approach: impl Fn(&Vector3<f64>, &Touch) -> f64) -> SpatialPair {
        let approach = |(d, touch): (&Vector3<f64>, &Touch)| affine_row(d) * approach(d, touch);
        let fit = self.moment_inverse * self.arms.iter().zip(touches).map(approach).sum::<Vector3<f64>>();
        [Vector3::new(0.0, 0.0, -fit.x), Vector3::new(-fit.z, fit.y, 0.0)]
    }

    /// Distributes the wrench over the contacts; `None` if a contact would have to pull or slip. `disc` is the radius of a disc within the law's
    /// cone, for a unit normal impulse [-].
    pub fn distribute(&mut self, wrench: &SpatialPair, disc: f64, impulses: &mut [Vector3<f64>]) -> Option<()> {
        let Sole { arms, moment_inverse, pressure, weights, friction_forces, .. } = self;
        let [force, moment] = wrench;
        let pressure =
            normal_distribution(arms, moment_inverse, &Vector3::new(force.z, -moment.y, moment.x), pressure)?;
        let friction_forces =
            friction_distribution(arms, pressure, &force.xy(), moment.z, disc, weights, friction_forces)?;
        for ((impulse, f), &n) in impulses.iter_mut().zip(friction_forces).zip(pressure) {
            *impulse = Vector3::new(f.x, f.y, n);
        }
        Some(())
    }
}

/// Normal impulses of least norm for a load (F_z, -m_y, m_x) [N·s, N·m·s], none of which pulls. `all` is N⁻¹ of all contacts.
fn normal_distribution<'a>(
    arms: &[Vector3<f64>],
    all: &Matrix3<f64>,
    load: &Vector3<f64>,
    pressure: &'a mut Vec<f64>,
) -> Option<&'a [f64]> {
    pressure.clear();
    pressure.resize(arms.len(), 1.0);
    let mut fit = all * load;
    loop {
        let mut least = -PULL_ROUNDING * load.x; // a smaller pull is rounding
        let mut worst = None;
        for (i, (n, d)) in pressure.iter_mut().zip(arms).enumerate().filter(|(_, (n, _))| **n != 0.0) {
            *n = affine_row(d).dot(&fit);
            if *n < least {
                (least, worst) = (*n, Some(i));
            }
            *n = n.max(0.0);
        }
        let Some(worst) = worst else { return Some(pressure) };
        pressure[worst] = 0.0;
        let rest = arms.iter().zip(&*pressure).filter(|(_, n)| **n != 0.0).map(|(d, _)| d);
        fit = inverse_moment_matrix(rest)? * load;
    }
}

/// Friction impulses for a force and a moment: in proportion to the normal impulses, reduced where a contact would slip.
fn friction_distribution<'a>(
    arms: &[Vector3<f64>],
    pressure: &[f64],
    force: &Vector2<f64>,
    moment: f64,
    disc: f64,
    weights: &mut Vec<f64>,
    friction_forces: &'a mut Vec<Vector2<f64>>,
) -> Option<&'a [Vector2<f64>]> {
    weights.clear();
    weights.extend_from_slice(pressure);
    for _ in 0..MAX_TRIALS {
        let total: f64 = weights.iter().sum();
        if total <= 0.0 {
            return None; // no contact is loaded, or all slip whatever their weight
        }
        let centre: Vector2<f64> = arms.iter().zip(&*weights).map(|(d, g)| d.xy() * *g).sum::<Vector2<f64>>() / total;
        let inertia: f64 = arms.iter().zip(&*weights).map(|(d, g)| g * (d.xy() - centre).norm_squared()).sum();
        let twist = if inertia > 0.0 { (moment - centre.perp(force)) / inertia } else { 0.0 };
        let mean = force / total;
        friction_forces.clear();
        let mut slips = false;
        for ((d, g), n) in arms.iter().zip(weights.iter_mut()).zip(pressure) {
            let from = d.xy() - centre;
            let f = (mean + Vector2::new(-from.y, from.x) * twist) * *g;
            let size = f.norm();
            let excess = if size > 0.0 { size / (disc * n) } else { 0.0 }; // infinite without friction
            if excess > 1.0 {
                *g /= OVERREDUCTION * excess * excess;
                slips = true;
            }
            friction_forces.push(f);
        }
        if !slips {
            return Some(friction_forces);
        }
    }
    None
}

/// q_i.
fn affine_row(d: &Vector3<f64>) -> Vector3<f64> {
    Vector3::new(1.0, d.x, d.y)
}

/// N⁻¹.
fn inverse_moment_matrix<'a>(arms: impl Iterator<Item = &'a Vector3<f64>>) -> Option<Matrix3<f64>> {
    let n = arms.fold(Matrix3::zeros(), |n, d| n + affine_row(d) * affine_row(d).transpose());
    let regular = n.determinant() > COLLINEAR * n.diagonal().product();
    if regular { n.try_inverse() } else { None }
}

#[cfg(test)]
mod tests;
