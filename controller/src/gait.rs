//! The top level of the controller: the motion of the centre of gravity and of the swing foot, section 3.3 of the paper.
//!
//! ```text
//!   stand → sway → lift → walk (exchange, exchange, …) → land → rest
//! ```
//! In phase *walk* both axes are pendulums (31), (32). Their states follow the measured centre of gravity: `gait/observer.rs`. The
//! energy rule (39) keeps the lateral pendulum on its orbit, and that orbit sets the time of the steps: `gait/lateral.rs`. The
//! sagittal pendulum is stabilised by the landing position of the foot and by the ankle, `gait/placement.rs`, or by the paper's
//! energy rule (42), `gait/stepping.rs`. Limits widen when the robot is pushed: `gait/deviation.rs`. The exchange of support is in
//! `gait/exchange.rs`, the phases before *walk* in `gait/phases.rs`, *land* and *rest* in `gait/balance.rs`.

mod balance;
mod deviation;
mod exchange;
mod lateral;
mod model;
mod observer;
mod orbits;
mod phases;
mod placement;
mod reference;
mod stepping;
mod touch;

pub use messages::wire::Phase;
pub use model::{GaitModel, GaitState};
pub use reference::Reference;

use crate::support::Task;
use crate::swing::MinimumJerkState;
use messages::scene::Gait;

impl GaitModel {
    /// Plans one control period: advances the state and returns the reference for the lower levels. `load` is that of the swing foot, over
    /// the weight of the robot [-].
    pub fn plan(&self, state: &mut GaitState, task: &Task, load: f64) -> Reference {
        self.change_phase(state);
        let [_, sway, ..] = self.parameters.phases;
        let reference = match state.phase {
            Phase::Stand => self.hold(state, task),
            Phase::Sway => self.move_com(state, task, [self.lean, self.release], sway),
            Phase::Lift => self.lift_foot(state, task),
            Phase::Walk => self.walk(state, task, load),
            Phase::Land | Phase::Rest => self.balance(state, task),
        };
        state.since += self.h;
        state.time += self.h;
        reference
    }

    fn change_phase(&self, state: &mut GaitState) {
        let [stand, sway, lift, land] = self.parameters.phases;
        let next = match state.phase {
            Phase::Stand if self.scene.gait == Gait::Walk && state.since >= stand && !self.stopping(state) => {
                Phase::Sway
            }
            Phase::Sway if state.since >= sway => Phase::Lift,
            Phase::Lift if state.since >= lift => Phase::Walk,
            Phase::Land if state.since >= land => Phase::Rest,
            _ => return,
        };
        state.phase = next;
        state.since = 0.0;
        if next == Phase::Rest {
            return;
        }
        for axis in &mut state.com {
            *axis = MinimumJerkState::at_rest(axis.x);
        }
    }
}
