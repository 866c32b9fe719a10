//! What `biped set` asks of the gait outlives the controller: one that takes over or restarts in the same run gets it by requests of the
//! launcher, after its first answer. They then appear among the requests of the run.

use messages::port::{Action, GaitRequest, Verdict, ask};
use messages::session::Session;
use messages::wire::{Served, Stamp};

/// What the controllers of the present run have accepted by request.
#[derive(Debug, Default)]
pub struct SetPoints {
    /// Period of two steps [s].
    period: Option<f64>,
    /// Walking speed [m/s].
    speed: Option<f64>,
    /// Whether the walk ends.
    stops: bool,
    /// Number of their run; 0 before its first reading.
    run: u64,
    /// Run and epoch of the controller in control; zero before its first answer.
    controller: (u64, u64),
}

impl SetPoints {
    /// Takes note of a request that has been served.
    pub fn note(&mut self, served: &Served) {
        let Ok(Action::Gait(request)) = Action::decode(&served.request) else { return };
        if served.verdict != Verdict::Done as u64 {
            return;
        }
        self.begin_run(served.stamp.run);
        match request {
            GaitRequest::Set { period, speed } => {
                (self.period, self.speed) = (period.or(self.period), speed.or(self.speed));
            }
            GaitRequest::Stop => self.stops = true,
        }
    }

    /// A new run begins with the set-points of the scene, and with those that its controller got before the first reading.
    fn begin_run(&mut self, run: u64) {
        if self.run != 0 && run != self.run {
            (self.period, self.speed, self.stops) = (None, None, false);
        }
        self.run = run;
    }

    /// If another controller answered than before in the same run, sends the requests to it. `command` is the stamp of the latest command in
    /// the run with this number. Returns a sentence if the controller does not take them.
    pub fn pass_on(&mut self, run: u64, command: &Stamp, session: &Session) -> Option<String> {
        let controller = (command.run, command.epoch);
        if command.run != run || command.epoch == 0 || controller == self.controller {
            return None;
        }
        let before = std::mem::replace(&mut self.controller, controller);
        self.begin_run(run);
        if before.0 != run {
            return None;
        }
        let refused = |request| match ask(session, Action::Gait(request)) {
            Ok(reply) if reply.verdict == Verdict::Done as u64 => None,
            Ok(reply) => Some(Verdict::text(reply.verdict).to_string()),
            Err(error) => Some(error.to_string()),
        };
        let SetPoints { period, speed, stops, .. } = *self;
        let set = period.or(speed).map(|_| GaitRequest::Set { period, speed });
        let stop = stops.then_some(GaitRequest::Stop);
        let reason = set.into_iter().chain(stop).find_map(refused)?;
        Some(format!("the new controller walks as the scene says, and not as `biped set` asked: {reason}"))
    }
}
