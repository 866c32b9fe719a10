//! State of the robot: x and xdot.

use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::{Model, Motion, finite};
use messages::scene::{Base, Initial};
use messages::turn::sin_cos;
use nalgebra::{Matrix3, Rotation3, Vector3};

/// Least determinant of the axes of the virtual joints [-]. It is the cosine of the pitch; at zero, the joints lose a direction.
const MIN_DETERMINANT: f64 = 1e-6;
/// Half of a rotation angle below which (1 − ½d cot ½d)/d² is computed from its series [rad]. The closed form would lose digits by
/// cancellation. The next term of the series contributes less than 1e-17 of w.
const SERIES_ANGLE: f64 = 0.02;
/// Half of a rotation angle below which sin(x)/x rounds to 1 [rad]: the next term of the series is x²/6.
const SINC_ANGLE: f64 = 1e-8;

/// Generalised position and velocity of (1).
///
/// `xdot` has one entry per degree of freedom: base, then joints in the model's order (`Model::joint_dof`). `x` has the same order. With a
/// quaternion base, `x` is position, unit quaternion w, x, y, z, and joints; `xdot` is the velocity of the base's origin and the angular
/// velocity, both in W, and the joint rates.
#[derive(Clone, Debug, PartialEq)]
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

    /// The initial state of a scene. Velocities in W become rates of the base's coordinates.
    ///
    /// # Errors
    /// A list of joints with the wrong length, a value that is not finite, a motion that the base cannot perform, or a clearance without
    /// contact points.
    pub fn initial(model: &Model, initial: &Initial) -> Result<Self, PlantError> {
        let mut state = State::zero(model);
        let offset = model.coordinates() - model.dofs();
        let joints = [("initial.joints", &initial.joints), ("initial.joint_rates", &initial.joint_rates)];
        for (what, list) in joints {
            let right = list.is_empty() || list.len() == model.joint_dof.len();
            if !right || list.iter().any(|value| !value.is_finite()) {
                let rule = format!("empty or {} finite numbers, one per joint", model.joint_dof.len());
                return Err(PlantError::value(what, list, rule));
            }
        }
        for (k, &dof) in model.joint_dof.iter().enumerate() {
            state.x[dof + offset] = initial.joints.get(k).copied().unwrap_or(0.0);
            state.xdot[dof] = initial.joint_rates.get(k).copied().unwrap_or(0.0);
        }
        state.set_initial_pose(model, initial)?;
        state.set_initial_rates(model, initial)?;
        if let (Some(clearance), Some(up)) = (initial.clearance, height_coordinate(model.base)) {
            let mut pose = Pose::new(model);
            kinematics::pose(model, &state, &mut pose);
            state.x[up] += height_offset(model, &pose, clearance)?;
        }
        Ok(state)
    }

    /// Position and orientation of the base.
    fn set_initial_pose(&mut self, model: &Model, initial: &Initial) -> Result<(), PlantError> {
        let position = finite(initial.position, || "initial.position".into())?;
        let rotation = orientation(initial)?;
        let [roll, pitch, yaw] = initial.orientation_deg.map(f64::to_radians);
        match model.base {
            Base::Fixed => {}
            Base::Planar if roll != 0.0 || yaw != 0.0 => {
                let rule = "without roll and yaw, which a planar base does not have";
                return Err(PlantError::value("initial.orientation_deg", initial.orientation_deg, rule));
            }
            Base::Planar => self.x[..3].copy_from_slice(&[position.x, position.z, pitch]),
            Base::Virtual => {
                self.x[..6].copy_from_slice(&[position.x, position.y, position.z, yaw, pitch, roll]);
            }
            Base::Quaternion => {
                self.x[..3].copy_from_slice(position.as_slice());
                self.x[3..7].copy_from_slice(&kinematics::quaternion(&rotation));
            }
        }
        Ok(())
    }

    /// Rates of the base's coordinates from its velocity and angular velocity in W.
    fn set_initial_rates(&mut self, model: &Model, initial: &Initial) -> Result<(), PlantError> {
        let velocity = finite(initial.velocity, || "initial.velocity".into())?;
        let spin = finite(initial.angular_velocity, || "initial.angular_velocity".into())?;
        let foreign = |what: &str, value: [f64; 3], good: bool, rule: &str| {
            if good { Ok(()) } else { Err(PlantError::value(what, value, rule)) }
        };
        match model.base {
            Base::Fixed => {
                let rule = "zero, for the base is fixed";
                foreign("initial.velocity", initial.velocity, velocity == Vector3::zeros(), rule)?;
                foreign("initial.angular_velocity", initial.angular_velocity, spin == Vector3::zeros(), rule)?;
            }
            Base::Planar => {
                let rule = "in the plane of x and z, for the base is planar";
                foreign("initial.velocity", initial.velocity, velocity.y == 0.0, rule)?;
                foreign("initial.angular_velocity", initial.angular_velocity, spin.x == 0.0 && spin.z == 0.0, rule)?;
                self.xdot[..3].copy_from_slice(&[velocity.x, velocity.z, spin.y]);
            }
            Base::Virtual | Base::Quaternion => {
                let mut pose = Pose::new(model);
                kinematics::pose(model, self, &mut pose);
                let axes = Matrix3::from_columns(&[4, 5, 6].map(|link: usize| pose.links[link].column.angular));
                let rule = "another pitch: at ±90° the virtual joints cannot turn every way";
                let lost = || PlantError::value("initial.orientation_deg", initial.orientation_deg, rule);
                let rates =
                    axes.try_inverse().filter(|_| axes.determinant().abs() > MIN_DETERMINANT).ok_or_else(lost)? * spin;
                self.xdot[..3].copy_from_slice(velocity.as_slice());
                self.xdot[3..6].copy_from_slice(rates.as_slice());
            }
        }
        Ok(())
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
                false => (1.0 - half / half.tan()) / square,
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

    /// Greatest rotation rate of the base or a joint [rad/s]. A base on virtual joints is left out: near its singular pitch, the rates of
    /// the joints exceed its angular velocity.
    pub fn fastest_turn(&self, model: &Model) -> f64 {
        let base = match model.base {
            Base::Fixed | Base::Virtual => 0.0,
            Base::Planar => self.xdot[2].abs(),
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

/// Index of the coordinate along z.
fn height_coordinate(base: Base) -> Option<usize> {
    match base {
        Base::Fixed => None,
        Base::Planar => Some(1),
        Base::Virtual | Base::Quaternion => Some(2),
    }
}

/// Rotation from the base's axes to W: yaw, then pitch, then roll.
pub(crate) fn orientation(initial: &Initial) -> Result<Matrix3<f64>, PlantError> {
    let angles = finite(initial.orientation_deg.map(f64::to_radians), || "initial.orientation_deg".into())?;
    Ok(Rotation3::from_euler_angles(angles.x, angles.y, angles.z).into_inner())
}

/// Height by which to lift the robot so that its lowest contact point is `clearance` above the ground z = 0 [m].
pub(crate) fn height_offset(model: &Model, pose: &Pose, clearance: f64) -> Result<f64, PlantError> {
    let heights = model.contact_points.iter().map(|point| pose.height(point));
    let lowest = heights.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() && clearance.is_finite() {
        return Ok(clearance - lowest);
    }
    Err(PlantError::value("initial.clearance", clearance, "finite and of a robot with contact points, or absent"))
}
