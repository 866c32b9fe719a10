//! Exit codes, and the failures that end the program with them.

use crate::unsolved_problem::UnsolvedProblem;
use controller::ControllerError;
use messages::controller_session::ControllerSessionError;
use messages::load::SceneError;
use messages::peer_environment::PeerEnvironmentError;
use messages::port::PortError;
use plant::PlantError;
use std::fmt::Display;
use std::process::ExitCode;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Exit codes of all commands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Exit {
    /// Success.
    Ok = 0,
    /// Wrong arguments, or an invalid scene.
    Usage = 2,
    /// The other process did not start, or ended too early.
    PeerMissing = 3,
    /// The simulation or the controller failed, or results could not be written.
    Fault = 4,
    /// The other process has another program version, scene or pace.
    Incompatible = 5,
    /// Shared memory is missing, full or blocked.
    SharedMemory = 6,
    /// The robot fell.
    Fell = 7,
    /// A contact problem was not solved to plant.tolerance. It is saved to a file.
    Unsolved = 8,
    /// The system refused a privilege that `--rt=require` needs.
    Refused = 9,
    /// A program breaks a rule of the wire format.
    Nonconforming = 10,
    /// The run is complete, but its recording ended early.
    Unrecorded = 11,
    /// SIGINT (Ctrl-C) or SIGTERM.
    Interrupted = 130,
}

/// The exit codes, as `biped --help` shows them.
pub const HELP: &str = "\
Exit codes:
    0  success
    2  wrong arguments, or an invalid scene
    3  the other process did not start, or ended too early
    4  the simulation or the controller failed, or results could not be written
    5  the other process has another program version, scene or pace
    6  shared memory is missing, full or blocked
    7  the robot fell
    8  a contact problem was not solved to plant.tolerance; it is saved to a file
    9  the system refused what --rt=require needs
   10  a program breaks a rule of the wire format (`biped conform`)
   11  the run is complete, but its recording ended early
  130  interrupted by Ctrl-C or TERM";

impl From<Exit> for ExitCode {
    fn from(exit: Exit) -> ExitCode {
        ExitCode::from(exit as u8)
    }
}

impl Exit {
    /// The meaning of a child's exit code. An unknown code, or death by a signal (`None`), is a fault.
    pub fn of_child(code: Option<i32>) -> Exit {
        let known = [
            Exit::Ok,
            Exit::Usage,
            Exit::PeerMissing,
            Exit::Incompatible,
            Exit::SharedMemory,
            Exit::Unsolved,
            Exit::Refused,
            Exit::Interrupted,
        ];
        known.into_iter().find(|exit| code == Some(*exit as i32)).unwrap_or(Exit::Fault)
    }

    /// Why a run ended early, in a few words; `None` if the code is not about an early end.
    pub fn cause(self) -> Option<&'static str> {
        match self {
            Exit::Ok | Exit::Fell | Exit::Nonconforming | Exit::Unrecorded => None,
            Exit::Usage | Exit::Refused => Some("refused"),
            Exit::PeerMissing => Some("other process missing"),
            Exit::Fault => Some("fault"),
            Exit::Incompatible => Some("incompatible processes"),
            Exit::SharedMemory => Some("shared memory"),
            Exit::Unsolved => Some("unsolved contact problem"),
            Exit::Interrupted => Some("interrupted"),
        }
    }
}

/// Why a command failed: an exit code and an error message.
#[derive(Debug)]
pub struct Failure {
    /// The exit code.
    pub exit: Exit,
    /// The error message.
    pub message: String,
    /// An unsolved contact problem, to be saved to a file.
    pub unsolved: Option<Box<UnsolvedProblem>>,
}

impl Failure {
    /// A failure without a contact problem.
    pub fn new(exit: Exit, message: impl ToString) -> Failure {
        Failure { exit, message: message.to_string(), unsolved: None }
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
        let exit = Exit::of_child(Some(error.exit_code().into()));
        Failure::new(exit, error)
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
        let exit = Exit::of_child(Some(error.exit_code().into()));
        Failure::new(exit, error)
    }
}

impl From<PlantError> for Failure {
    fn from(error: PlantError) -> Self {
        plant::process::PlantProcessError::from(error).into()
    }
}
