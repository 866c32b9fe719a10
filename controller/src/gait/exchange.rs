//! Change of support, (35) and (36): when it is due, and the plan seen from the other foot.

use super::{GaitModel, GaitState, Phase};
use crate::measures::Measures;
use crate::support::Task;
use crate::swing::Travel;

impl GaitModel {
    /// Whether the legs are to change roles now: x_2 has come to W_2/2 and moves on.
    pub fn exchange_due(&self, state: &GaitState) -> bool {
        let [_, lateral] = state.com;
        state.phase == Phase::Walk
            && lateral.x >= 0.5 * self.width
            && lateral.v > 0.0
            && state.since >= self.measures.least_step
    }

    /// Hands the plan over to the other support. `task` is measured before, in the old support frame.
    pub fn exchange(&self, state: &mut GaitState, task: &Task) {
        let swing = task.swing();
        let Measures { trim, step_slew, .. } = self.measures;
        state.trim = (state.trim + 0.3 * (swing.x - state.landing)).clamp(-trim, trim);
        let [sagittal, lateral] = &mut state.com;
        sagittal.x -= swing.x;
        // The exchange comes up to one period late, beyond W_2/2. Seen from the new foot that is as far short of it, and
        // the speed there on the same orbit is less: without this each exchange would add energy.
        let x = self.width - lateral.x;
        let slower = lateral.v.powi(2) - self.omega[1].powi(2) * (lateral.x.powi(2) - x.powi(2));
        *lateral = Travel { x, v: -slower.max(0.0).sqrt(), a: -lateral.a };
        state.height -= swing.z;
        state.foot = Travel::at(-swing.x);
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
}
