//! The ankles of the supporting foot: where their torques put the zero-moment point.
//!
//! ```text
//!   τ = M (g J_c3 + a J_ck) ± c M (g (x_k − p) − a x_3)
//! ```
//! p is the zero-moment point [m], a the acceleration of the centre of gravity along axis k, J its Jacobian in the joint's column, c the
//! cosine between the joint's axis and the ground, ± the sign of J_ck. The first term is the torque of a point mass, whose zero-moment
//! point is x_k − a x_3/g; the second moves that point to p. Over a level joint both make ∓M (g p + h a), h being the joint's height: from
//! the balance of moments of a foot without mass.

use crate::support::{Chain, Task};

/// One of the two joints of an ankle.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Ankle {
    /// It moves the zero-moment point along axis 2.
    Roll,
    /// It moves it along axis 1.
    Pitch,
}

impl Ankle {
    /// Both.
    pub const BOTH: [Ankle; 2] = [Ankle::Roll, Ankle::Pitch];

    /// Its number in support order, at the supporting foot.
    pub fn joint(self) -> usize {
        match self {
            Ankle::Roll => 0,
            Ankle::Pitch => 1,
        }
    }

    /// The axis, 0 forward or 1 sideways, along which it moves the zero-moment point.
    pub fn axis(self) -> usize {
        1 - self.joint()
    }
}

impl Chain {
    /// Torque of the supporting foot's joint `ankle` for the zero-moment point `p` [m] at the acceleration `a` [m/s²] along its axis [N·m].
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

    /// The torques between which the zero-moment point stays within ±`edge` [m] of the sole's centre, the centre of gravity being a
    /// pendulum of rate `omega` [1/s] that falls away from it: a = ω² (x − p) [N·m].
    pub fn ankle_range(&self, task: &Task, ankle: Ankle, gravity: f64, omega: f64, edge: f64) -> [f64; 2] {
        let x = task.x[ankle.axis()];
        let [a, b] = [-edge, edge].map(|p| self.ankle_torque(task, ankle, gravity, p, omega * omega * (x - p)));
        [a.min(b), a.max(b)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::Joints;
    use messages::robot::{CROUCH, table_1};

    /// Standing still, the torque at each ankle joint is what gravity asks for, M g ∂x_c3/∂q; with the zero-moment point below the joint it
    /// is the horizontal force times the joint's height.
    #[test]
    fn the_torque_of_a_zero_moment_point_is_that_of_the_balance_of_moments() {
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
        // but for the foot's own mass, a fourteenth, which the pendulum moves with the rest
        assert!((torque.abs() / force - 1.0).abs() < 0.05, "{torque} beside {force} N·m");
    }
}
