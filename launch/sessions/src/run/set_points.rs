//! The set-points of `biped set` outlive their controller: one that takes over or restarts in the same run gets them by a request of the
//! launcher, after its first answer. They then appear among the requests of the run.

use messages::port::{Action, Verdict, ask};
use messages::session::Session;
use messages::wire::{Served, Stamp};

/// The set-points that the controllers of the present run have accepted by request.
#[derive(Debug, Default)]
pub struct SetPoints {
    /// Period of two steps [s].
    period: Option<f64>,
    /// Walking speed [m/s].
    speed: Option<f64>,
    /// Number of their run; 0 before its first reading.
    run: u64,
    /// Run and epoch of the controller in control; zero before its first answer.
    controller: (u64, u64),
}

impl SetPoints {
    /// Takes note of a request that has been served.
    pub fn note(&mut self, served: &Served) {
        let Ok(Action::Set { period, speed }) = Action::decode(&served.request) else { return };
        if served.verdict != Verdict::Done as u64 {
            return;
        }
        self.begin_run(served.stamp.run);
        (self.period, self.speed) = (period.or(self.period), speed.or(self.speed));
    }

    /// A new run begins with the set-points of the scene, and with those that its controller got before the first reading.
    fn begin_run(&mut self, run: u64) {
        if self.run != 0 && run != self.run {
            (self.period, self.speed) = (None, None);
        }
        self.run = run;
    }

    /// If another controller answered than before in the same run, sends the set-points to it. `command` is the stamp of the latest command in
    /// the run with this number. Returns a sentence if the controller does not take them.
    pub fn pass_on(&mut self, run: u64, command: &Stamp, session: &Session) -> Option<String> {
        let controller = (command.run, command.epoch);
        if command.run != run || command.epoch == 0 || controller == self.controller {
            return None;
        }
        let before = std::mem::replace(&mut self.controller, controller);
        self.begin_run(run);
        let SetPoints { period, speed, .. } = *self;
        if before.0 != run || period.or(speed).is_none() {
            return None;
        }
        let reason = match ask(session, Action::Set { period, speed }) {
            Ok(reply) if reply.verdict == Verdict::Done as u64 => return None,
            Ok(reply) => Verdict::text(reply.verdict).to_string(),
            Err(error) => error.to_string(),
        };
        Some(format!(
            "the new controller has the speed and period of the scene, and not those of `biped set`: {reason}"
        ))
    }
}
