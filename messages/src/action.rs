//! What may be asked of a running plant or controller, and what they say to it.

use crate::wire::{Request, Stamped, VERDICTS};

/// What is asked for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Action {
    /// Of the plant: let time stand still.
    Pause,
    /// Of the plant: let it go on.
    Resume,
    /// Of the plant: run for so many control periods, then stand still.
    Step {
        /// Their number.
        periods: u64,
    },
    /// Of the plant: begin anew, as another run.
    Reset {
        /// With another seed, if there is one.
        seed: Option<u64>,
    },
    /// Of the plant: push the centre of mass of a body.
    Push {
        /// Number of the body in the scene.
        body: usize,
        /// In W [N·s].
        impulse: [f64; 3],
        /// [s].
        duration: f64,
    },
    /// Of the plant: switch the drives on again after a fault.
    Rearm,
    /// Of the controller: gait set-points.
    Set {
        /// Period of two steps, if it is to change [s].
        period: Option<f64>,
        /// Walking speed, if it is to change [m/s].
        speed: Option<f64>,
    },
}

/// What is said to it; the order is that of [`VERDICTS`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// It is done.
    Done,
    /// This is for the other process to do.
    WrongProcess,
    /// The scene has no such body.
    NoSuchBody,
    /// A number is no number, or absurd.
    OutOfRange,
    /// The request cannot be read.
    Damaged,
}

impl Verdict {
    /// In words.
    pub fn text(verdict: u64) -> &'static str {
        usize::try_from(verdict).ok().and_then(|index| VERDICTS.get(index)).copied().unwrap_or("an unknown answer")
    }
}

/// Set-points that stay as they are, on the wire.
const UNCHANGED: f64 = f64::INFINITY;

impl Action {
    /// What a message asks for.
    ///
    /// # Errors
    /// Why it cannot be read.
    pub fn decode(request: &Request) -> Result<Action, Verdict> {
        let change = |value: f64| (value != UNCHANGED).then_some(value);
        match request.kind {
            _ if !request.is_sound() => Err(Verdict::Damaged),
            0 => Ok(Action::Pause),
            1 => Ok(Action::Resume),
            2 => Ok(Action::Step { periods: request.count }),
            3 => Ok(Action::Reset { seed: (request.seed != 0).then_some(request.seed) }),
            4 => {
                Ok(Action::Push { body: request.count as usize, impulse: request.impulse, duration: request.duration })
            }
            5 => Ok(Action::Rearm),
            6 => Ok(Action::Set { period: change(request.period), speed: change(request.speed) }),
            _ => Err(Verdict::Damaged),
        }
    }

    /// As a message, not yet sealed.
    pub fn encode(self) -> Request {
        let blank = Request::default();
        match self {
            Action::Pause => Request { kind: 0, ..blank },
            Action::Resume => Request { kind: 1, ..blank },
            Action::Step { periods } => Request { kind: 2, count: periods, ..blank },
            Action::Reset { seed } => Request { kind: 3, seed: seed.unwrap_or(0), ..blank },
            Action::Push { body, impulse, duration } => {
                Request { kind: 4, count: body as u64, impulse, duration, ..blank }
            }
            Action::Rearm => Request { kind: 5, ..blank },
            Action::Set { period, speed } => {
                Request { kind: 6, period: period.unwrap_or(UNCHANGED), speed: speed.unwrap_or(UNCHANGED), ..blank }
            }
        }
    }

    /// Whether it is for the controller; else it is for the plant.
    pub fn is_for_controller(self) -> bool {
        matches!(self, Action::Set { .. })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wire::REQUESTS;

    #[test]
    fn every_request_reads_back_as_what_was_asked() {
        let asks = [
            Action::Pause,
            Action::Resume,
            Action::Step { periods: 3 },
            Action::Reset { seed: Some(7) },
            Action::Push { body: 4, impulse: [1.0, -2.0, 0.5], duration: 0.05 },
            Action::Rearm,
            Action::Set { period: None, speed: Some(0.15) },
        ];
        assert_eq!(asks.len(), REQUESTS.len());
        for (kind, ask) in asks.into_iter().enumerate() {
            let request = ask.encode();
            assert_eq!((request.kind, Action::decode(&request.sealed())), (kind as u64, Ok(ask)));
            assert_eq!(Action::decode(&request), Err(Verdict::Damaged), "not sealed");
        }
        assert_eq!(Action::decode(&Request { kind: 7, ..Request::default() }.sealed()), Err(Verdict::Damaged));
    }
}
