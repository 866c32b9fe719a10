//! Lines on standard error while a plant runs.
//!
//! The plant reports when joints are damped, when the drives are switched off or driven again, when a command is refused, and
//! when the controller changes. It writes at most one line per second, except when the drives are switched off.

use crate::Simulation;
use messages::clock::now_ns;
use messages::log;
use messages::wire::PlantState;

const SECOND_NS: u64 = 1_000_000_000;

/// The last report, and its time.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct PlantLog {
    state: PlantState,
    refused: u64,
    takeovers: u64,
    written_ns: u64,
}

impl PlantLog {
    /// Writes a line if something has changed.
    pub fn update(&mut self, simulation: &mut Simulation) {
        let state = match simulation.state() {
            PlantState::Damp => PlantState::Damp,
            PlantState::Fault => PlantState::Fault,
            _ => PlantState::Run,
        };
        let tally = simulation.commands().tally();
        let refused = tally.refused.iter().sum();
        if (state, refused, tally.takeovers) == (self.state, self.refused, self.takeovers) {
            return;
        }
        let urgent = state == PlantState::Fault && self.state != PlantState::Fault;
        if !urgent && now_ns() - self.written_ns < SECOND_NS {
            return;
        }
        let time = simulation.sensors().stamp.time();
        let age = simulation.commands().age();
        let drives = match (self.state, state) {
            (PlantState::Wait, PlantState::Run) => None, // the first command of the run
            (before, now) if before == now => None,
            (_, PlantState::Damp) => {
                Some(format!("the newest command is {age} control periods old: joints are damped"))
            }
            (_, PlantState::Fault) => {
                Some(format!("the controller has been silent for {age} control periods: drives are off until re-armed"))
            }
            _ => Some("the controller drives again".into()),
        };
        let tally = simulation.commands().tally();
        let counters = (tally.takeovers != self.takeovers || refused != self.refused).then(|| tally.to_string());
        let sentences: Vec<String> = drives.into_iter().chain(counters).collect();
        *self = PlantLog { state, refused, takeovers: tally.takeovers, written_ns: self.written_ns };
        if !sentences.is_empty() {
            self.written_ns = now_ns();
            log(format_args!("t {time:.3} s: {}", sentences.join("; ")));
        }
    }
}
