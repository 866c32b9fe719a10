//! A controller of your own as a process: the walking controller of the paper, to begin from.
//!
//!     biped run walk --controller PROGRAM                                   # started by biped
//!     biped plant walk --session lab &                                      # or attached to a session by its name
//!     PROGRAM --session lab
//!
//! BIPED_SESSION=lab in the environment means the same as `--session lab`.

use controller::{Controller, ControllerError};
use messages::controller_session::{ControllerSession, ControllerSessionError, Event, Reading};
use messages::port::{PortError, Verdict};
use messages::scene::Scene;
use messages::wire::{Telemetry, Torques};
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static STOP: AtomicBool = AtomicBool::new(false); // set by TERM and by Ctrl-C

/// Ends with the exit code of docs/WIRE.md.
pub fn main() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let session = match &arguments[..] {
        [] => None,
        [option, name] if option == "--session" => Some(name.as_str()),
        _ => {
            return failure(2, format!("only --session NAME is understood, not {}", arguments.join(" ")));
        }
    };
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Relaxed)) {
        return failure(4, format!("signals: {error}"));
    }
    match control(session) {
        Ok(()) => ExitCode::SUCCESS,
        Err(Failed::Session(error)) => failure(error.exit_code(), error.to_string()),
        Err(Failed::Controller(error)) => failure(4, error.to_string()),
    }
}

fn failure(code: u8, sentence: String) -> ExitCode {
    messages::log(format!("error: {sentence}"));
    ExitCode::from(code)
}

/// Why the controller ended before the plant's goodbye.
pub enum Failed {
    /// The session failed, or the program was stopped.
    Session(ControllerSessionError),
    /// No torques for this robot or posture.
    Controller(ControllerError),
}

impl From<ControllerSessionError> for Failed {
    fn from(error: ControllerSessionError) -> Failed {
        Failed::Session(error)
    }
}

impl From<PortError> for Failed {
    fn from(error: PortError) -> Failed {
        Failed::Session(error.into())
    }
}

impl From<ControllerError> for Failed {
    fn from(error: ControllerError) -> Failed {
        Failed::Controller(error)
    }
}

/// Answers every reading of the encoders, and the requests of `biped set`, until the plant's goodbye.
pub fn control(session: Option<&str>) -> Result<(), Failed> {
    let (mut session, scene) = ControllerSession::join(session, &STOP)?;
    let mut walk = Walk::new(&scene)?;
    while !STOP.load(Relaxed) {
        session.serve(|period, speed| walk.set(period, speed))?;
        match session.poll()? {
            Event::Idle => {}
            Event::Goodbye => return Ok(()),
            Event::Reading(reading) => {
                let (torques, telemetry) = walk.tick(&scene, &reading)?;
                session.answer(torques, telemetry)?;
            }
        }
    }
    Err(ControllerSessionError::Interrupted.into())
}

/// The controller of the paper. Change its torques in `tick`, or replace it.
struct Walk {
    controller: Controller,
    has_run: bool,
}

impl Walk {
    fn new(scene: &Scene) -> Result<Walk, ControllerError> {
        Ok(Walk { controller: Controller::new(scene)?, has_run: false })
    }

    /// Other set-points of the gait: period of two steps [s] and walking speed [m/s].
    fn set(&mut self, period: Option<f64>, speed: Option<f64>) -> Verdict {
        self.controller.answer_set(period, speed)
    }

    /// The torques of one control period. A new run starts a new controller.
    fn tick(&mut self, scene: &Scene, reading: &Reading) -> Result<(Torques, Telemetry), ControllerError> {
        if reading.begins && self.has_run {
            *self = Walk::new(scene)?;
        }
        self.has_run = true;
        let torques = self.controller.tick(&reading.encoders)?;
        Ok((torques, self.controller.telemetry()))
    }
}
