//! A controller of your own as a program: arguments, signals, the session and exit codes, around what you write.
//!
//! ```no_run
//! use biped_messages::controller_program::{self, Answer, Outcome, ProgramController};
//! use biped_messages::{scene::Scene, wire::Encoders};
//!
//! struct Limp;
//!
//! impl ProgramController for Limp {
//!     fn new(_scene: &Scene) -> Outcome<Limp> {
//!         Ok(Limp)
//!     }
//!     fn tick(&mut self, _encoders: &Encoders) -> Outcome<Answer> {
//!         Ok(Answer::default()) // no torque
//!     }
//! }
//!
//! fn main() -> std::process::ExitCode {
//!     controller_program::run::<Limp>()
//! }
//! ```

use crate::action::GaitRequest;
use crate::controller_session::{ControllerSession, ControllerSessionError, Event};
use crate::exit::Exit;
use crate::log;
use crate::port::{PortError, Verdict};
use crate::scene::Scene;
use crate::wire::{Encoders, Telemetry, Torques};
use std::error::Error;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Set by TERM and by Ctrl-C.
static STOP: AtomicBool = AtomicBool::new(false);

/// A result of your code. Any error ends the program.
pub type Outcome<T> = Result<T, Box<dyn Error>>;

/// Torques for a control period, and what recordings show of the controller.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answer {
    /// Torques [N·m].
    pub torques: Torques,
    /// State of the gait.
    pub telemetry: Telemetry,
}

impl From<Torques> for Answer {
    /// Torques without a state of the gait.
    fn from(torques: Torques) -> Answer {
        Answer { torques, ..Answer::default() }
    }
}

/// A controller that [`run`] can run.
pub trait ProgramController: Sized {
    /// The controller at the start of a run of this scene.
    ///
    /// # Errors
    /// If it does not fit the scene.
    fn new(scene: &Scene) -> Outcome<Self>;

    /// Gets the simulated time of the first reading of a run before that reading [s]. It is above zero if the controller takes over.
    fn begin_at(&mut self, _time: f64) {}

    /// The answer to a reading of the encoders. Every reading comes exactly once.
    ///
    /// # Errors
    /// If there are no torques.
    fn tick(&mut self, encoders: &Encoders) -> Outcome<Answer>;

    /// Carries out `biped set`: period of two steps [s] and walking speed [m/s], if they are to change.
    fn set(&mut self, _period: Option<f64>, _speed: Option<f64>) -> Verdict {
        Verdict::NotServed
    }

    /// Carries out `biped set --stop`: the robot comes to rest.
    fn stop(&mut self) -> Verdict {
        Verdict::NotServed
    }
}

/// Why the controller ended before the plant's goodbye.
#[derive(Debug, thiserror::Error)]
pub enum ProgramError {
    /// The session failed, or the program was stopped.
    #[error(transparent)]
    Session(#[from] ControllerSessionError),
    /// The controller failed.
    #[error("{0}")]
    Controller(#[from] Box<dyn Error>),
}

impl From<PortError> for ProgramError {
    fn from(error: PortError) -> ProgramError {
        ControllerSessionError::from(error).into()
    }
}

impl ProgramError {
    /// The exit code of the program.
    pub fn exit_code(&self) -> Exit {
        match self {
            ProgramError::Session(error) => error.exit_code(),
            ProgramError::Controller(_) => Exit::Fault,
        }
    }
}

/// The whole `main` of a controller: joins the session of `--session NAME`, or that of the environment, and answers until the plant's
/// goodbye, TERM or Ctrl-C. After TERM or Ctrl-C it says nothing: its exit code is [`Exit::Interrupted`].
pub fn run<C: ProgramController>() -> ExitCode {
    let arguments: Vec<_> = std::env::args().skip(1).collect();
    let session = match &arguments[..] {
        [] => None,
        [option, name] if option == "--session" => Some(name.as_str()),
        _ => return failure(Exit::Usage, format!("only --session NAME is understood, not {}", arguments.join(" "))),
    };
    if let Err(error) = ctrlc::set_handler(|| STOP.store(true, Relaxed)) {
        return failure(Exit::Fault, format!("signals: {error}"));
    }
    match control::<C>(session, &STOP) {
        Ok(()) => ExitCode::SUCCESS,
        Err(ProgramError::Session(ControllerSessionError::Interrupted)) => Exit::Interrupted.into(), // as asked, so it is no error
        Err(error) => failure(error.exit_code(), error.to_string()),
    }
}

fn failure(exit: Exit, sentence: String) -> ExitCode {
    log(format!("error: {sentence}"));
    exit.into()
}

/// Answers every reading of the encoders, and the requests of `biped set`, until the plant's goodbye or until `stop` is true. A new run of
/// the plant gets a new controller.
///
/// # Errors
/// See [`ProgramError`].
pub fn control<C: ProgramController>(session: Option<&str>, stop: &AtomicBool) -> Result<(), ProgramError> {
    let (mut session, scene) = ControllerSession::join(session, stop)?;
    let (mut controller, mut is_new) = (C::new(&scene)?, true);
    while !stop.load(Relaxed) {
        session.serve(|request| match request {
            GaitRequest::Set { period, speed } => controller.set(period, speed),
            GaitRequest::Stop => controller.stop(),
        })?;
        match session.poll()? {
            Event::Idle => {}
            Event::Goodbye => return Ok(()),
            Event::Reading(reading) => {
                if reading.begins && !is_new {
                    controller = C::new(&scene)?;
                }
                if reading.begins {
                    controller.begin_at(reading.stamp.time());
                }
                is_new = false;
                let Answer { torques, telemetry } = controller.tick(&reading.encoders)?;
                session.answer(torques, telemetry)?;
            }
        }
    }
    Err(ControllerSessionError::Interrupted.into())
}
