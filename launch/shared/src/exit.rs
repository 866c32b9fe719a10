//! Failures that end the program, each with its exit code.

pub use messages::exit::Exit;

use crate::unsolved_problem::UnsolvedProblem;
use controller::ControllerError;
use messages::controller_session::ControllerSessionError;
use messages::load::SceneError;
use messages::peer_environment::PeerEnvironmentError;
use messages::port::PortError;
use plant::PlantError;
use std::fmt::Display;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Why a command failed: an exit code and an error message.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// The error message. Without one, nothing is printed.
    pub message: String,
    /// An unsolved contact problem, to be saved to a file.
    pub unsolved: Option<Box<UnsolvedProblem>>,
}

impl Failure {
    /// A failure without a contact problem.
    pub fn new(exit: Exit, message: impl ToString) -> Failure {
        Failure { exit, message: message.to_string(), unsolved: None }
    }

    /// An interruption that nobody needs to hear of, because whoever started this process has asked for it.
    pub fn silent_interruption() -> Failure {
        Failure::new(Exit::Interrupted, "")
    }

    /// The same failure. The message of an interruption that names no results also names those that are `kept`.
    #[must_use]
    pub fn keeping(self, kept: impl Display) -> Failure {
        match self.exit == Exit::Interrupted && self.message == INTERRUPTED {
            true => Failure::new(Exit::Interrupted, format!("{INTERRUPTED}: {kept}")),
            false => self,
        }
    }
}

/// The message of an interruption that has nothing else to say.
const INTERRUPTED: &str = "interrupted";

/// Checks whether the user has interrupted the program.
///
/// # Errors
/// [`Exit::Interrupted`] if so.
pub fn check_interrupt(stop: &AtomicBool) -> Result<(), Failure> {
    if stop.load(Relaxed) { Err(Failure::new(Exit::Interrupted, INTERRUPTED)) } else { Ok(()) }
}

/// The same, for a command that prints each result when it has it.
///
/// # Errors
/// If it is set.
pub fn check_interrupt_after_results(stop: &AtomicBool) -> Result<(), Failure> {
    check_interrupt(stop).map_err(|failure| failure.keeping("the results above are those until then"))
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        Failure::new(Exit::Usage, error)
    }
}

impl From<PeerEnvironmentError> for Failure {
    fn from(error: PeerEnvironmentError) -> Self {
        match error {
            PeerEnvironmentError::Malformed(_) => Failure::new(Exit::Usage, error),
            PeerEnvironmentError::Port(error) => error.into(),
        }
    }
}

impl From<PortError> for Failure {
    fn from(error: PortError) -> Self {
        Failure::new(error.exit_code(), error)
    }
}

impl From<plant::process::PlantProcessError> for Failure {
    fn from(error: plant::process::PlantProcessError) -> Self {
        use plant::process::PlantProcessError as E;
        match error {
            E::Port(error) => error.into(),
            E::NoController(..) => Failure::new(Exit::PeerMissing, error),
            E::Plant(PlantError::Unsolved { .. }) => unsolved_failure(error),
            E::Plant(PlantError::Value { .. }) => Failure::new(Exit::Usage, error), // an invalid value of the scene
            E::Plant(_) | E::Silent(_) => Failure::new(Exit::Fault, error),
            E::Interrupted => Failure::new(Exit::Interrupted, error),
        }
    }
}

fn unsolved_failure(error: plant::process::PlantProcessError) -> Failure {
    let failure = Failure::new(Exit::Unsolved, &error);
    Failure { unsolved: UnsolvedProblem::from_error(error).map(Box::new), ..failure }
}

impl From<controller::process::ProcessError> for Failure {
    fn from(error: controller::process::ProcessError) -> Self {
        use controller::process::ProcessError as E;
        match error {
            E::Session(error) => error.into(),
            E::Controller(ControllerError::Singular { .. }) => Failure::new(Exit::Fault, error),
            E::Controller(_) => Failure::new(Exit::Usage, error), // an invalid value of the scene
        }
    }
}

impl From<ControllerSessionError> for Failure {
    fn from(error: ControllerSessionError) -> Self {
        Failure::new(error.exit_code(), error)
    }
}

impl From<PlantError> for Failure {
    fn from(error: PlantError) -> Self {
        plant::process::PlantProcessError::from(error).into()
    }
}
