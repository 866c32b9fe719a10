//! A controller of your own as a process: the walking controller of the paper, to begin from.
//!
//!     biped run walk --controller PROGRAM                                   # started by biped
//!     biped plant walk --session lab &                                      # or attached to a session by its name
//!     PROGRAM --session lab
//!
//! BIPED_SESSION=lab in the environment means the same as `--session lab`.

use controller::Controller;
use messages::controller_program::{Answer, Outcome, ProgramController, run};
use messages::port::{GaitRequest, Verdict};
use messages::scene::Scene;
use messages::wire::Encoders;
use std::process::ExitCode;

/// The controller of the paper. Change its torques in `tick`, or replace it.
struct Walk(Controller);

impl ProgramController for Walk {
    fn new(scene: &Scene) -> Outcome<Walk> {
        Ok(Walk(Controller::new(scene)?))
    }

    fn begin_at(&mut self, time: f64) {
        self.0.begin_at(time);
    }

    fn tick(&mut self, encoders: &Encoders) -> Outcome<Answer> {
        let torques = self.0.tick(encoders)?;
        Ok(Answer { torques, telemetry: self.0.telemetry() })
    }

    fn set(&mut self, period: Option<f64>, speed: Option<f64>) -> Verdict {
        self.0.answer(GaitRequest::Set { period, speed })
    }

    fn stop(&mut self) -> Verdict {
        self.0.answer(GaitRequest::Stop)
    }
}

fn main() -> ExitCode {
    run::<Walk>()
}
