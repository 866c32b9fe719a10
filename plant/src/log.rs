//! What a plant says on standard error while it runs: a line when drives are damped, switched off or driven again, when a
//! command is refused, when the controller changes; at most one each second but for the drives going off.

use crate::Simulation;
use crate::watchdog::Mode;
use messages::clock::now_ns;
use messages::log;

const SECOND: u64 = 1_000_000_000;

/// What was said last, and when.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct PlantLog {
    mode: Mode,
    refused: u64,
    takeovers: u64,
    written_ns: u64,
}

impl PlantLog {
    /// Says what is new.
    pub fn update(&mut self, simulation: &mut Simulation) {
        let mode = match simulation.mode() {
            Mode::Damp => Mode::Damp,
            Mode::Fault => Mode::Fault,
            _ => Mode::Run,
        };
        let tally = simulation.commands().tally();
        let refused = tally.refused.iter().sum();
        if (mode, refused, tally.takeovers) == (self.mode, self.refused, self.takeovers) {
            return;
        }
        let urgent = mode == Mode::Fault && self.mode != Mode::Fault;
        if !urgent && now_ns() - self.written_ns < SECOND {
            return;
        }
        let time = simulation.sensors().stamp.sim_ns as f64 * 1e-9;
        let age = simulation.commands().age();
        let drives = match (self.mode, mode) {
            (Mode::Wait, Mode::Run) => None, // the beginning
            (before, now) if before == now => None,
            (_, Mode::Damp) => Some(format!("the newest command is {age} control periods old: joints are damped")),
            (_, Mode::Fault) => {
                Some(format!("the controller has been silent for {age} control periods: drives are off until re-armed"))
            }
            _ => Some("the controller drives again".into()),
        };
        let tally = simulation.commands().tally();
        let others = (tally.takeovers != self.takeovers || refused != self.refused).then(|| tally.to_string());
        let said: Vec<String> = drives.into_iter().chain(others).collect();
        *self = PlantLog { mode, refused, takeovers: tally.takeovers, written_ns: self.written_ns };
        if !said.is_empty() {
            self.written_ns = now_ns();
            log(format_args!("t {time:.3} s: {}", said.join("; ")));
        }
    }
}
