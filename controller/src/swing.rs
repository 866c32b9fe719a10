//! The swing foot: its height (43), and its motion forward to the landing position.

/// r_max of f_h: a robot that swings farther inward than the reference orbit lifts the foot to at most 1.3² of h_max [-].
const MAX_RELATIVE_DEPTH: f64 = 1.3;

/// Height of the swing foot as a function of the centre of gravity, f_h of (43) and Figure 5.
///
/// ```text
///   x_t3 = f_h(x_2 − W_2/2),   f_h(z) = h_max min(r, r_max)²,   r = −z/h_d for z < 0, otherwise 0
/// ```
/// h_d is the distance from W_2/2 to the turning point of the reference orbit. So the foot is highest at the turning point, and it
/// leaves and meets the ground with slope zero in x_2. An f_h with a kink would throw the robot.
#[derive(Clone, Copy, Debug)]
pub struct SwingHeight {
    /// h_max [m].
    pub height: f64,
    /// h_d [m].
    pub reach: f64,
}

impl SwingHeight {
    /// Height [m] and its rate [m/s] for the centre of gravity at `inward` = x_2 − W_2/2 [m] moving at `v` [m/s].
    pub fn height_and_rate(&self, inward: f64, v: f64) -> (f64, f64) {
        let r = (-inward / self.reach).max(0.0); // (43)
        let rate = if r < MAX_RELATIVE_DEPTH { -2.0 * self.height * r * v / self.reach } else { 0.0 };
        (self.height * r.min(MAX_RELATIVE_DEPTH).powi(2), rate)
    }
}

/// Largest acceleration of a minimum-jerk motion from rest to rest, over d/t² for a distance d in a time t: 10/√3 [-].
pub const MINIMUM_JERK_PEAK: f64 = 5.7735;

/// Position, velocity and acceleration along one axis: the state of a minimum-jerk motion.
#[derive(Clone, Copy, Debug, Default, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct MinimumJerkState {
    /// Position [m].
    pub x: f64,
    /// Velocity [m/s].
    pub v: f64,
    /// Acceleration [m/s²].
    pub a: f64,
}

impl MinimumJerkState {
    /// State of rest at `x` [m].
    pub fn at_rest(x: f64) -> Self {
        MinimumJerkState { x, v: 0.0, a: 0.0 }
    }

    /// The state after one period `h` [s] of the minimum-jerk motion that comes to rest at `target` [m] in `time_left` [s].
    ///
    /// The state follows the quintic from (x, v, a) to (target, 0, 0) exactly. Replanning with an unchanged target therefore stays on
    /// the same quintic. Its initial jerk is 60Δ/t³ − 36v/t² − 9a/t, with Δ = target − x.
    pub fn advance_toward(self, target: f64, time_left: f64, h: f64) -> MinimumJerkState {
        let t = time_left;
        let [d, v, a] = [target - self.x, self.v, self.a];
        let jerk = 60.0 * d / t.powi(3) - 36.0 * v / t.powi(2) - 9.0 * a / t;
        let snap = -360.0 * d / t.powi(4) + 192.0 * v / t.powi(3) + 36.0 * a / t.powi(2);
        let crackle = 720.0 * d / t.powi(5) - 360.0 * v / t.powi(4) - 60.0 * a / t.powi(3);
        MinimumJerkState {
            x: self.x + h * (v + h * (a / 2.0 + h * (jerk / 6.0 + h * (snap / 24.0 + h * crackle / 120.0)))),
            v: v + h * (a + h * (jerk / 2.0 + h * (snap / 6.0 + h * crackle / 24.0))),
            a: a + h * (jerk + h * (snap / 2.0 + h * crackle / 6.0)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_replanned_motion_arrives_at_rest_and_on_time() {
        let (h, n) = (1e-3, 300);
        let mut foot = MinimumJerkState { x: -0.06, v: 0.1, a: -2.0 };
        for k in 0..n {
            foot = foot.advance_toward(0.06, h * f64::from(n - k), h);
        }
        assert!((foot.x - 0.06).abs() < 1e-9 && foot.v.abs() < 1e-6, "{foot:?}");
    }

    #[test]
    fn the_rate_of_the_swing_height_is_its_derivative() {
        let lift = SwingHeight { height: 0.01, reach: 0.0112 };
        let (v, h) = (0.1, 1e-7);
        for inward in [-0.016, -0.0112, -0.004, 0.001] {
            let (now, rate) = lift.height_and_rate(inward, v);
            let (next, _) = lift.height_and_rate(inward + h * v, v);
            assert!(((next - now) / h - rate).abs() < 1e-6, "{inward}");
        }
    }
}
