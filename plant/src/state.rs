//! State of the robot: x and xdot.

use crate::model::{Model, Motion};
use messages::rotation::sin_cos;
use messages::scene::Base;
use nalgebra::Vector3;

/// Half of a rotation angle below which (1 − ½d cot ½d)/d² is computed from its series [rad]. The closed form would lose digits by
/// cancellation. The next term of the series contributes less than 1e-17 of w.
const SERIES_ANGLE: f64 = 0.02;
/// Half of a rotation angle below which sin(x)/x rounds to 1 [rad]: the next term of the series is x²/6.
const SINC_ANGLE: f64 = 1e-8;

/// Generalised position and velocity of (1).
///
/// `xdot` has one entry per degree of freedom: base, then joints in the model's order (`Model::joint_dof`). `x` has the same order. With a
/// quaternion base, `x` is position, unit quaternion w, x, y, z, and joints; `xdot` is the velocity of the base's centre of mass and the angular
/// velocity, both in W, and the joint rates.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct State {
    /// Generalised position [m, rad].
    pub x: Vec<f64>,
    /// Generalised velocity [m/s, rad/s].
    pub xdot: Vec<f64>,
}

impl State {
    /// All coordinates and rates zero.
    pub fn zero(model: &Model) -> Self {
        let mut state = State { x: vec![0.0; model.coordinates()], xdot: vec![0.0; model.dofs()] };
        if model.base == Base::Quaternion {
            state.x[3] = 1.0;
        }
        state
    }

    /// Copies another state of the same model without allocation.
    pub fn copy(&mut self, other: &State) {
        self.x.copy_from_slice(&other.x);
        self.xdot.copy_from_slice(&other.xdot);
    }

    /// x(t + h) = x + h xdot. A quaternion is rotated by exp(h w), which is exact for a constant angular velocity.
    pub fn advance(&mut self, model: &Model, h: f64) {
        let mut joints = 0;
        if model.base == Base::Quaternion {
            joints = 6;
            for i in 0..3 {
                self.x[i] += h * self.xdot[i];
            }
            let turned = rotated(&self.x[3..7], &self.xdot[3..6], h);
            self.x[3..7].copy_from_slice(&turned);
        }
        let offset = self.x.len() - self.xdot.len();
        for (x, xdot) in self.x[joints + offset..].iter_mut().zip(&self.xdot[joints..]) {
            *x += h * xdot;
        }
    }

    /// x ⊕ d: coordinates change by d. A quaternion is rotated by the rotation vector in d.
    pub fn displace(&mut self, model: &Model, by: impl Fn(usize) -> f64) {
        let mut joints = 0;
        if model.base == Base::Quaternion {
            joints = 6;
            self.x[..3].iter_mut().enumerate().for_each(|(i, x)| *x += by(i));
            let turned = rotated(&self.x[3..7], &[by(3), by(4), by(5)], 1.0);
            self.x[3..7].copy_from_slice(&turned);
        }
        let offset = self.x.len() - self.xdot.len();
        self.x[joints + offset..].iter_mut().zip(joints..).for_each(|(x, i)| *x += by(i));
    }

    /// The rate of the displacement `by` of [`State::displace`]. It equals xdot, except for a rotation vector d: dexp⁻¹_d(w) = w − ½ d × w
    /// + (1 − ½|d| cot ½|d|)/|d|² d × (d × w).
    ///
    /// # Source
    /// Hairer, Lubich & Wanner, *Geometric Numerical Integration*, III.4 and IV.7.
    pub fn displacement_rate(&self, model: &Model, by: &[f64], rate: &mut [f64]) {
        rate.copy_from_slice(&self.xdot);
        if model.base == Base::Quaternion {
            let (d, w) = (Vector3::from_column_slice(&by[3..6]), Vector3::from_column_slice(&rate[3..6]));
            let square = d.norm_squared();
            let half = 0.5 * square.sqrt();
            let factor = match half < SERIES_ANGLE {
                true => 1.0 / 12.0 + square / 720.0 + square * square / 30240.0,
                false => (1.0 - half / libm::tan(half)) / square,
            };
            let turn = d.cross(&w);
            rate[3..6].copy_from_slice((w - turn * 0.5 + d.cross(&turn) * factor).as_slice());
        }
    }

    /// Coordinate of the k-th joint of the scene [rad or m].
    pub fn joint(&self, model: &Model, k: usize) -> f64 {
        self.x[model.joint_dof[k] + self.x.len() - self.xdot.len()]
    }

    /// Rate of the k-th joint of the scene [rad/s or m/s].
    pub fn joint_rate(&self, model: &Model, k: usize) -> f64 {
        self.xdot[model.joint_dof[k]]
    }

    /// Greatest rotation rate of the base or a joint, virtual ones included [rad/s].
    pub fn fastest_turn(&self, model: &Model) -> f64 {
        let base = match model.base {
            Base::Fixed => 0.0,
            Base::Planar => self.xdot[2].abs(),
            Base::Virtual => self.xdot[3..6].iter().fold(0.0, |most, rate| f64::max(most, rate.abs())),
            Base::Quaternion => Vector3::from_column_slice(&self.xdot[3..6]).norm(),
        };
        let turning = model.joint_dof.iter().filter(|&&dof| model.links[dof + 1].motion == Motion::Revolute);
        turning.fold(base, |most, &dof| most.max(self.xdot[dof].abs()))
    }
}

/// exp(h w) q, of unit length: q turned by the angular velocity w in W for the time h.
fn rotated(q: &[f64], w: &[f64], h: f64) -> [f64; 4] {
    let half = 0.5 * h * (w[0] * w[0] + w[1] * w[1] + w[2] * w[2]).sqrt();
    // below SINC_ANGLE, sin(half)/half is 1 to rounding
    let (sin, cos) = sin_cos(half);
    let sinc = if half < SINC_ANGLE { 1.0 } else { sin / half };
    let [a, x, y, z] = [cos, 0.5 * h * sinc * w[0], 0.5 * h * sinc * w[1], 0.5 * h * sinc * w[2]];
    let product = [
        a * q[0] - x * q[1] - y * q[2] - z * q[3],
        a * q[1] + x * q[0] + y * q[3] - z * q[2],
        a * q[2] - x * q[3] + y * q[0] + z * q[1],
        a * q[3] + x * q[2] - y * q[1] + z * q[0],
    ];
    let length = product.iter().map(|c| c * c).sum::<f64>().sqrt();
    product.map(|c| c / length)
}
