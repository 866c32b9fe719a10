//! The initial state of a scene.

use crate::error::PlantError;
use crate::kinematics::{self, Pose};
use crate::model::{Model, finite};
use crate::state::State;
use messages::rotation::sin_cos;
use messages::scene::{Base, Initial};
use nalgebra::{Matrix3, Vector3};

/// Least determinant of the axes of the virtual joints [-]. It is the cosine of the pitch; at zero, the joints lose a direction.
const MIN_DETERMINANT: f64 = 1e-6;
impl State {
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
            let pose = Pose::of(model, &state);
            state.x[up] += height_offset(model, &pose, clearance)?;
        }
        Ok(state)
    }

    /// The same state with position and velocity of the frame that the scene gives the base, instead of those of its centre of mass.
    pub fn in_scene_frame(&self, model: &Model) -> State {
        let (pose, mut state) = (Pose::of(model, self), self.clone());
        let base = &pose.links[model.base_link];
        let arm = base.rotation * model.base_frame;
        let gain = base.velocity.angular.cross(&arm);
        let translation: &[usize] = match model.base {
            Base::Fixed => &[],
            Base::Planar => &[0, 2],
            Base::Virtual | Base::Quaternion => &[0, 1, 2],
        };
        for ((x, xdot), &axis) in state.x.iter_mut().zip(&mut state.xdot).zip(translation) {
            *x += arm[axis];
            *xdot += gain[axis];
        }
        state
    }

    /// Position and orientation of the base.
    fn set_initial_pose(&mut self, model: &Model, initial: &Initial) -> Result<(), PlantError> {
        let position = finite(initial.position, || "initial.position".into())?;
        let rotation = orientation(initial)?;
        let position = position - rotation * model.base_frame;
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
        let com_velocity = velocity - spin.cross(&(orientation(initial)? * model.base_frame));
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
                self.xdot[..3].copy_from_slice(&[com_velocity.x, com_velocity.z, spin.y]);
            }
            Base::Virtual | Base::Quaternion => {
                let pose = Pose::of(model, self);
                let axes = Matrix3::from_columns(&[4, 5, 6].map(|link: usize| pose.links[link].column.angular));
                let rule = "another pitch: at ±90° the virtual joints cannot turn every way";
                let lost = || PlantError::value("initial.orientation_deg", initial.orientation_deg, rule);
                let rates =
                    axes.try_inverse().filter(|_| axes.determinant().abs() > MIN_DETERMINANT).ok_or_else(lost)? * spin;
                self.xdot[..3].copy_from_slice(com_velocity.as_slice());
                self.xdot[3..6].copy_from_slice(rates.as_slice());
            }
        }
        Ok(())
    }
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
    let [(sr, cr), (sp, cp), (sy, cy)] = [angles.x, angles.y, angles.z].map(sin_cos);
    let rows = [
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ];
    Ok(Matrix3::from_fn(|i, j| rows[i][j]))
}

/// Height by which to lift the robot so that its lowest contact point is `clearance` above the ground under it [m].
pub(crate) fn height_offset(model: &Model, pose: &Pose, clearance: f64) -> Result<f64, PlantError> {
    let over_ground = |point| pose.height(point) - model.ground_at(&(pose.reference + pose.lowest(point)));
    let heights = model.contact_points.iter().map(over_ground);
    let lowest = heights.fold(f64::INFINITY, f64::min);
    if lowest.is_finite() && clearance.is_finite() {
        return Ok(clearance - lowest);
    }
    Err(PlantError::value("initial.clearance", clearance, "finite and of a robot with contact points, or absent"))
}
