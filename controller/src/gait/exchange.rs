//! Change of support, (35) and (36): when it is due, and the plan seen from the other foot.

use super::{GaitModel, GaitState, Phase};
use crate::pendulum::PendulumState;
use crate::scaled_parameters::ScaledParameters;
use crate::support::Task;
use crate::swing::MinimumJerkState;

/// Shares of an error that the next step is corrected by [-].
const LANDING_SHARE: f64 = 0.3;
const TIME_SHARE: f64 = 0.3;
const STEP_SHARE: f64 = 0.1;
/// Most that one step teaches, against all that can be learned [-].
const MAX_LESSON: f64 = 0.02;

impl GaitModel {
    /// Whether the legs are to change roles now: x_2 has come to W_2/2 and moves on, fast enough for an orbit over the other foot that is
    /// not too quick to step in.
    pub fn exchange_due(&self, state: &GaitState) -> bool {
        let [_, lateral] = state.com;
        let other = PendulumState { x: self.width - lateral.x, v: lateral.v };
        state.phase == Phase::Walk
            && lateral.x >= 0.5 * self.width
            && lateral.v > 0.0
            && other.energy(self.omega[1]) >= self.orbit_limits.quickest
            && state.since >= self.parameters.least_step
    }

    /// Hands the plan over to the other support. `task` is measured before, in the old support frame.
    pub fn exchange(&self, state: &mut GaitState, task: &Task) {
        let swing = task.swing();
        let ScaledParameters { step_slew, .. } = self.parameters;
        self.learn(state, swing.x);
        let [sagittal, lateral] = &mut state.com;
        sagittal.x -= swing.x;
        // The exchange comes up to one period late, beyond W_2/2. Seen from the new foot that is as far short of it, and
        // the speed there on the same orbit is less: without this each exchange would add energy.
        let x = self.width - lateral.x;
        let slower = lateral.v.powi(2) - self.omega[1].powi(2) * (lateral.x.powi(2) - x.powi(2));
        *lateral = MinimumJerkState { x, v: -slower.max(0.0).sqrt(), a: -lateral.a };
        state.height -= swing.z;
        state.foot = MinimumJerkState::at_rest(-swing.x);
        state.landing = -swing.x;
        state.steps += 1;
        state.since = 0.0;
        let stopping = self.stopping(state);
        if stopping && state.step == 0.0 {
            state.phase = Phase::Land;
            return;
        }
        let wanted = if stopping { 0.0 } else { self.step_length() };
        state.step += (wanted - state.step).clamp(-step_slew, step_slew);
    }

    /// Corrects the next steps by what this one, which landed at `landed` [m], was astray. One that a push disturbed teaches but little.
    fn learn(&self, state: &mut GaitState, landed: f64) {
        let ScaledParameters { max_length_correction, max_time_correction, .. } = self.parameters;
        let corrected = |learned: f64, share: f64, astray: f64, most: f64| {
            let lesson = (share * astray).clamp(-MAX_LESSON * most, MAX_LESSON * most);
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
