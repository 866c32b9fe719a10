//! The load of the swing foot: the vertical force of the ground on it, from encoders and torques alone.
//!
//! ```text
//!   F = −vᵀ(τ − (M + J_r 1) q̈)
//! ```
//! v are joint rates that raise the swing foot by 1 m/s and leave the rest of the task (27) as it is. The supporting foot and the height of
//! the centre of gravity do not move, so neither the ground under that foot nor gravity does work. The rest of the power is that of F. M is
//! the matrix of `constants.rs`, for the posture in the middle of a step. Velocity products are left out.

use crate::rate::RateSolver;
use crate::support::{JointMatrix, Joints, TaskVector, mirror};

/// Rate of the low-pass filter of F, for the robot of Table 1 [1/s]. A foot that lands takes its load in 10 to 20 ms.
const FILTER_RATE: f64 = 100.0;

/// Constants of the estimate.
#[derive(Clone, Debug)]
pub struct LoadModel {
    /// M + J_r 1, support order [kg·m²].
    inertia: JointMatrix,
    /// Weight of the robot [N].
    weight: f64,
    /// Weight of a new value in the filtered one [-].
    share: f64,
}

/// State of the estimate.
#[derive(Clone, Copy, Debug, Default, serde::Serialize, serde::Deserialize)]
pub struct LoadState {
    /// τ of the period before, support order [N·m].
    pub torque: Joints,
    /// F over the weight of the robot [-].
    pub load: f64,
}

impl LoadModel {
    /// The estimate for a robot with this inertia matrix [kg·m²] and weight [N], once each `period` [s]. `scale` is the ratio of the
    /// robot's times to those of Table 1.
    pub fn new(inertia: JointMatrix, weight: f64, period: f64, scale: f64) -> Self {
        LoadModel { inertia, weight, share: 1.0 - libm::exp(-FILTER_RATE / scale * period) }
    }

    /// Updates the load by the acceleration that the torque of the period before has caused [rad/s²].
    pub fn estimate(&self, state: &mut LoadState, solver: &RateSolver, acceleration: &Joints) {
        let rise = TaskVector::from([0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]);
        if let Some(v) = solver.rates(&rise, &Joints::zeros()) {
            let force = -v.dot(&(state.torque - self.inertia * acceleration));
            state.load += self.share * (force / self.weight - state.load);
        }
    }
}

impl LoadState {
    /// The load of the other foot, in the other support order. The two feet carry the weight together.
    pub fn exchanged(self) -> Self {
        LoadState { torque: mirror(&self.torque), load: 1.0 - self.load }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Chain;
    use messages::robot::{CROUCH, table_1};

    /// A robot that accelerates with one foot pressed on the ground. Its torques are those of gravity, of the foot and of the acceleration.
    #[test]
    fn the_load_is_the_force_on_the_foot_whatever_gravity_and_acceleration_are() {
        let chain = Chain::new(&table_1()).expect("the paper's robot");
        let task = chain.task(&Joints::from(CROUCH));
        let solver = RateSolver::new(&task.jacobian).expect("bent knees");
        let (inertia, weight, force) = (JointMatrix::identity() * 0.3, chain.total_mass * 9.81, 50.0);
        let row = |k: usize| task.jacobian.row(k).transpose();
        let acceleration = Joints::from_fn(|j, _| 3.0 - j as f64);
        let torque = weight * row(2) - force * row(5) + inertia * acceleration;
        let model = LoadModel::new(inertia, weight, 1e-3, 1.0);
        let mut state = LoadState { torque, load: 0.0 };
        for _ in 0..1000 {
            model.estimate(&mut state, &solver, &acceleration);
        }
        assert!((state.load * weight - force).abs() < 1e-9, "{} N", state.load * weight);
        let other = state.exchanged().load * weight;
        assert!((other + force - weight).abs() < 1e-9, "{other} N on the other foot");
    }
}
