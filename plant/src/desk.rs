//! The plant's desk: pause, step, reset, push, re-arm.

use crate::process::Next;
use crate::watchdog::Mode;
use crate::{PlantError, Simulation};
use messages::clock::random;
use messages::port::{Ask, Verdict};
use messages::wire::{Reply, Request};

/// Greatest push that is taken for one [N·s], and its longest duration [s].
const GREATEST_PUSH: f64 = 1000.0;
const LONGEST_PUSH: f64 = 60.0;

/// Whether time stands still, and from which control period on.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Desk {
    paused: bool,
    from: u64,
}

impl Desk {
    /// Does what is asked for, if it can be done.
    ///
    /// # Errors
    /// If the scene cannot begin anew.
    pub fn handle(&mut self, request: &Request, simulation: &mut Simulation) -> Result<(Reply, Next), PlantError> {
        let mut next = Next::Period { late_ns: 0 };
        let now = simulation.sensors().stamp.seq;
        let verdict = match Ask::of(request) {
            Err(verdict) => verdict,
            Ok(Ask::Pause) => self.stand(true, 0),
            Ok(Ask::Resume) => self.stand(false, 0),
            Ok(Ask::Step { periods }) => self.stand(true, now.saturating_add(periods)),
            Ok(Ask::Reset { seed }) => {
                simulation.reset(random(), seed)?;
                self.from = 0;
                next = Next::Afresh;
                Verdict::Done
            }
            Ok(Ask::Push { body, impulse, duration }) => push(simulation, body, impulse, duration),
            Ok(Ask::Rearm) => {
                simulation.intake().rearm();
                Verdict::Done
            }
            Ok(Ask::Set { .. }) => Verdict::WrongDesk,
        };
        simulation.intake().tally_mut().requests += 1;
        let state = if self.paused { Mode::Paused } else { simulation.mode() };
        Ok((Reply { stamp: simulation.sensors().stamp, verdict: verdict as u64, state: state as u64 }, next))
    }

    /// Whether time is to stand still before the control period `now`.
    pub fn stands_still(&self, now: u64) -> bool {
        self.paused && now >= self.from
    }

    fn stand(&mut self, paused: bool, from: u64) -> Verdict {
        *self = Desk { paused, from };
        Verdict::Done
    }
}

fn push(simulation: &mut Simulation, body: usize, impulse: [f64; 3], duration: f64) -> Verdict {
    let sane = impulse.iter().all(|part| part.abs() <= GREATEST_PUSH) && (0.0..=LONGEST_PUSH).contains(&duration);
    match sane {
        false => Verdict::OutOfRange,
        true if simulation.push(body, impulse, duration) => Verdict::Done,
        true => Verdict::NoSuchBody,
    }
}
