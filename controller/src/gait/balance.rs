//! The end of a stop: the robot comes to rest on both feet where they are, and stays balanced on them.
//!
//! ```text
//!   ξ = x + v/ω     ξ̇ = ω (ξ − p)     p = ξ_0 + (1 + s) (ξ − ξ_0)   ⇒   ξ − ξ_0 decays as e^(−sωt)
//! ```
//! ξ_0 is the middle between the feet, one of which may stand before the other. At the exchange of support ξ is near the new supporting foot
//! in a steady walk, so the step under way can be the last. The state is the measured one, as in *walk*: a push is caught by the same law.
//! Across, the zero-moment point p may be anywhere between the outer edges of the soles, and sets the loads of the feet. Along, the ankles
//! move it away from the mean of the soles' centres, weighted by the loads.

use super::model::{GaitModel, GaitState};
use super::reference::Reference;
use super::stepping::pendulum;
use crate::support::Task;

/// s along and across: rate at which ξ returns to the middle, over ω [-]. With 0 it would stay where it is. Across it is slower, so that
/// the foot in front, near which ξ is, carries the weight until ξ has returned along.
const RETURN: [f64; 2] = [0.5, 0.3];

impl GaitModel {
    /// One control period on both feet.
    pub(super) fn balance(&self, state: &mut GaitState, task: &Task) -> Reference {
        self.observe(state, task);
        let (foot, [along, across]) = (task.x[3], self.zmp_range);
        let led = |k: usize, middle: f64| {
            let capture = state.com[k].x + state.com[k].v / self.omega[k]; // ξ
            middle + (1.0 + RETURN[k]) * (capture - middle)
        };
        let p_2 = led(1, 0.5 * self.width).clamp(-across, self.width + across);
        let load = (1.0 - p_2 / self.width).clamp(0.0, 1.0);
        let centre = (1.0 - load) * foot;
        let p_1 = led(0, 0.5 * foot).clamp(centre - along, centre + along);
        for (k, p) in [p_1, p_2].into_iter().enumerate() {
            state.com[k] = pendulum(state.com[k], &self.propagator[k], -self.omega[k].powi(2) * p);
        }
        self.reference(state, task, [0.0; 2], load)
    }
}
