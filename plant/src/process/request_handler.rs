//! Requests to the plant: pause, resume, step, reset, push, re-arm.

use super::control_loop::ExchangeOutcome;
use crate::{PlantError, Simulation};
use messages::clock::random;
use messages::port::{Action, Verdict};
use messages::wire::{PlantState, Reply, Request};

/// Largest impulse of a push that is accepted [N·s].
pub const MAX_PUSH_IMPULSE: f64 = 1000.0;
/// Longest duration of a push that is accepted [s]. As in a scene, it has to be greater than 0.
pub const MAX_PUSH_DURATION: f64 = 60.0;

/// Whether simulated time is to stand still, and from which control period on.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct RequestHandler {
    paused: bool,
    from: u64,
}

impl RequestHandler {
    /// Carries out a request, if that is possible.
    ///
    /// # Errors
    /// If the scene cannot be started again.
    pub fn handle(
        &mut self,
        request: &Request,
        simulation: &mut Simulation,
    ) -> Result<(Reply, ExchangeOutcome), PlantError> {
        let mut outcome = ExchangeOutcome::Advance { late_ns: 0 };
        let now = simulation.sensors().stamp.seq;
        let verdict = match Action::decode(request) {
            Err(verdict) => verdict,
            Ok(Action::Pause) => self.set_paused(true, 0),
            Ok(Action::Resume) => self.set_paused(false, 0),
            Ok(Action::Step { periods }) => self.set_paused(true, now.saturating_add(periods)),
            Ok(Action::Reset { seed }) => {
                simulation.reset(random(), seed)?;
                self.from = 0;
                outcome = ExchangeOutcome::Restart;
                Verdict::Done
            }
            Ok(Action::Push { body, impulse, duration }) => push(simulation, body, impulse, duration),
            Ok(Action::Rearm) => {
                simulation.commands().rearm();
                Verdict::Done
            }
            Ok(Action::Gait(_)) => Verdict::WrongProcess,
        };
        simulation.commands().tally_mut().requests += 1;
        let state = if self.paused { PlantState::Paused } else { simulation.state() };
        Ok((Reply { stamp: simulation.sensors().stamp, verdict: verdict as u64, state: state as u64 }, outcome))
    }

    /// Whether simulated time is to stand still before control period `now`.
    pub fn is_paused(&self, now: u64) -> bool {
        self.paused && now >= self.from
    }

    fn set_paused(&mut self, paused: bool, from: u64) -> Verdict {
        *self = RequestHandler { paused, from };
        Verdict::Done
    }
}

/// Whether impulse [N·s] and duration [s] of a push are within [`MAX_PUSH_IMPULSE`] and [`MAX_PUSH_DURATION`].
pub fn is_push_accepted(impulse: &[f64; 3], duration: f64) -> bool {
    impulse.iter().all(|part| part.abs() <= MAX_PUSH_IMPULSE) && duration > 0.0 && duration <= MAX_PUSH_DURATION
}

fn push(simulation: &mut Simulation, body: usize, impulse: [f64; 3], duration: f64) -> Verdict {
    match is_push_accepted(&impulse, duration) {
        false => Verdict::OutOfRange,
        true if simulation.push(body, impulse, duration) => Verdict::Done,
        true => Verdict::NoSuchBody,
    }
}
