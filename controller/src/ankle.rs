//! The ankle of the supporting foot: the torques that belong to a position of the zero-moment point.
//!
//! ```text
//!   τ = M (g J_c3 + a J_ck) ± c M (g (x_k − p) − a x_3)
//! ```
//! p is the zero-moment point [m], a the acceleration of the centre of gravity along axis k, J its Jacobian in the joint's column, c
//! the cosine between the joint's axis and the ground, and ± the sign of J_ck. The first term is the torque for a point mass,
//! whose zero-moment point is x_k − a x_3/g. The second term moves that point to p. For a level joint at height h the sum is
//! ∓M (g p + h a), which is the balance of moments of a foot without mass.

use crate::support::{Chain, Task};

/// One of the two joints of an ankle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ankle {
    /// Moves the zero-moment point along axis 2.
    Roll,
    /// Moves the zero-moment point along axis 1.
    Pitch,
}

impl Ankle {
    /// Both joints.
    pub const BOTH: [Ankle; 2] = [Ankle::Roll, Ankle::Pitch];

    /// Number of the joint in support order, at the supporting foot.
    pub fn joint(self) -> usize {
        match self {
            Ankle::Roll => 0,
            Ankle::Pitch => 1,
        }
    }

    /// The axis along which the joint moves the zero-moment point: 0 forward, 1 sideways.
    pub fn axis(self) -> usize {
        1 - self.joint()
    }
}

impl Chain {
    /// Torque of the joint `ankle` of the supporting foot for the zero-moment point `p` [m] and the acceleration `a` [m/s²] along
    /// its axis [N·m].
    pub fn ankle_torque(&self, task: &Task, ankle: Ankle, gravity: f64, p: f64, a: f64) -> f64 {
        let (k, j) = (ankle.axis(), ankle.joint());
        let [lift, lever] = [2, k].map(|row| task.jacobian[(row, j)]);
        let level = match ankle {
            Ankle::Roll => 1.0,
            Ankle::Pitch => task.roll_cosine,
        };
        let moved = gravity * (task.x[k] - p) - a * task.x[2];
        self.total_mass * (gravity * lift + a * lever + level.copysign(lever) * moved)
    }

    /// Range of torques for which the zero-moment point stays within ±`edge` [m] of the sole's centre [N·m]. `acceleration` is that of
    /// the centre of gravity for a zero-moment point [m/s² of m].
    pub fn ankle_range(
        &self,
        task: &Task,
        ankle: Ankle,
        gravity: f64,
        edge: f64,
        acceleration: impl Fn(f64) -> f64,
    ) -> [f64; 2] {
        let [a, b] = [-edge, edge].map(|p| self.ankle_torque(task, ankle, gravity, p, acceleration(p)));
        [a.min(b), a.max(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Joints;
    use messages::robot::{CROUCH, table_1};

    /// At rest the torque at each ankle joint is that of gravity, M g ∂x_c3/∂q. With the zero-moment point below the joint it is the
    /// horizontal force times the height of the joint.
    #[test]
    fn the_ankle_torque_satisfies_the_balance_of_moments() {
        let chain = Chain::new(&table_1()).expect("the paper's robot");
        let mut s = Joints::from(CROUCH);
        (s[0], s[1], s[6]) = (0.2, s[1] + 0.05, s[6] - 0.02);
        let task = chain.task(&s);
        for ankle in Ankle::BOTH {
            let (k, j) = (ankle.axis(), ankle.joint());
            let gravity = chain.total_mass * 9.81 * task.jacobian[(2, j)];
            let torque = chain.ankle_torque(&task, ankle, 9.81, task.x[k], 0.0);
            assert!((torque - gravity).abs() < 1e-12, "{ankle:?}: {torque} beside {gravity} N·m");
        }
        let torque = chain.ankle_torque(&task, Ankle::Roll, 9.81, 0.0, 2.0);
        let force = chain.total_mass * 2.0 * 0.05; // the roll joint of Table 1 is .05 m above the sole's centre
        // The tolerance covers the mass of the foot, a fourteenth of the robot, which the pendulum model accelerates too.
        assert!((torque.abs() / force - 1.0).abs() < 0.05, "{torque} beside {force} N·m");
    }
}
