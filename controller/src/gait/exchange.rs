//! Exchange of support, (35) and (36): when it is due, and the transformation of the plan to the other foot.

use super::model::{GaitModel, GaitState};
use crate::pendulum::PendulumState;
use crate::scaled_parameters::ScaledParameters;
use crate::support::Task;
use crate::swing::MinimumJerkState;
use messages::wire::Phase;

/// Share of the error of the landing position by which the correction changes after a step [-].
const LANDING_SHARE: f64 = 0.3;
/// The same share for the error of the step duration [-].
const TIME_SHARE: f64 = 0.3;
/// The same share for the error of the step length [-].
const STEP_SHARE: f64 = 0.1;
/// Largest change of the correction of duration or length after one step, over the largest correction [-]. A step that a push
/// disturbed therefore changes them only a little.
const MAX_LESSON: f64 = 0.02;

impl GaitModel {
    /// Whether the legs exchange their roles now: x_2 has passed W_2/2 and moves on, and the following orbit is not quicker than
    /// the quickest one allowed.
    pub fn exchange_due(&self, state: &GaitState) -> bool {
        let [_, lateral] = state.com;
        let other = PendulumState { x: self.width - lateral.x, v: lateral.v };
        state.phase == Phase::Walk
            && lateral.x >= 0.5 * self.width
            && lateral.v > 0.0
            && other.energy(self.omega[1]) >= self.orbit_limits.quickest
            && state.since >= self.parameters.least_step
    }

    /// Transforms the plan to the other supporting foot. `task` is the task before the exchange, in the old support frame.
    pub fn exchange(&self, state: &mut GaitState, task: &Task) {
        let swing = task.swing();
        self.learn(state, swing.x);
        let [sagittal, lateral] = &mut state.com;
        sagittal.x -= swing.x;
        // The exchange takes place up to one period late, beyond W_2/2. Seen from the new foot the robot is as far short of W_2/2,
        // where the speed on the same orbit is smaller. Without this correction each exchange would add energy.
        let x = self.width - lateral.x;
        let slower = lateral.v.powi(2) - self.omega[1].powi(2) * (lateral.x.powi(2) - x.powi(2));
        *lateral = MinimumJerkState { x, v: -slower.max(0.0).sqrt(), a: -lateral.a };
        state.height -= swing.z;
        state.ground = None;
        state.foot = MinimumJerkState::at_rest(-swing.x);
        state.landing = -swing.x;
        state.resumed = false;
        state.steps += 1;
        state.since = 0.0;
        if self.stopping(state) {
            state.phase = Phase::Land;
            state.urgency = 0.0;
        }
    }

    /// Updates the corrections by the errors of the step that has just landed at `landed` [m].
    fn learn(&self, state: &mut GaitState, landed: f64) {
        let ScaledParameters { max_length_correction, max_time_correction, .. } = self.parameters;
        let corrected = |learned: f64, share: f64, error: f64, most: f64| {
            let lesson = (share * error).clamp(-MAX_LESSON * most, MAX_LESSON * most);
            (learned + lesson).clamp(-most, most)
        };
        let (landing, step, since) = (state.landing, state.step, state.since);
        let learned = &mut state.corrections;
        learned.landing =
            (learned.landing + LANDING_SHARE * (landed - landing)).clamp(-max_length_correction, max_length_correction);
        if state.steps > 0 && !self.observer.is_disabled() {
            learned.time = corrected(learned.time, TIME_SHARE, 0.5 * self.scene.period - since, max_time_correction);
            learned.step = corrected(learned.step, STEP_SHARE, step - landed, max_length_correction);
        }
    }
}
