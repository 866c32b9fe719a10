//! Failures: a negative code and a sentence. The code is minus the exit code of `biped` for the same failure.

use messages::controller_session::ControllerSessionError;
use messages::peer_environment::PeerEnvironmentError;
use messages::port::PortError;
use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int};
use std::fmt;
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Wrong arguments, calls in the wrong order, or an environment that `biped run` has not set.
pub const BIPED_MISUSE: c_int = -2;
/// No plant sent sensors.
pub const BIPED_NO_PLANT: c_int = -3;
/// `biped_plan` has no torques for this robot, or this library has a defect.
pub const BIPED_DEFECT: c_int = -4;
/// The session has another contract, or it already has a controller.
pub const BIPED_INCOMPATIBLE: c_int = -5;
/// Shared memory is missing, full or blocked.
pub const BIPED_SHARED_MEMORY: c_int = -6;
/// `biped_stop` was called.
pub const BIPED_STOPPED: c_int = -130;

/// A failure.
#[derive(Debug, PartialEq)]
pub struct CallFailure {
    code: c_int,
    sentence: String,
}

impl CallFailure {
    /// A failure with one of the codes above.
    pub fn new(code: c_int, sentence: impl ToString) -> CallFailure {
        CallFailure { code, sentence: sentence.to_string() }
    }

    /// The code.
    pub fn code(&self) -> c_int {
        self.code
    }

    /// A mistake of the caller.
    pub fn misuse(sentence: impl ToString) -> CallFailure {
        CallFailure::new(BIPED_MISUSE, sentence)
    }
}

impl fmt::Display for CallFailure {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str(&self.sentence)
    }
}

impl From<PortError> for CallFailure {
    fn from(error: PortError) -> CallFailure {
        CallFailure::new(-c_int::from(error.exit_code() as u8), error)
    }
}

impl From<PeerEnvironmentError> for CallFailure {
    fn from(error: PeerEnvironmentError) -> CallFailure {
        match error {
            PeerEnvironmentError::Malformed(sentence) => CallFailure::misuse(sentence),
            PeerEnvironmentError::Port(error) => error.into(),
        }
    }
}

impl From<ControllerSessionError> for CallFailure {
    fn from(error: ControllerSessionError) -> CallFailure {
        match error {
            ControllerSessionError::Environment(error) => error.into(),
            ControllerSessionError::Port(error) => error.into(),
            ControllerSessionError::NoPlant(_) => CallFailure::new(BIPED_NO_PLANT, error),
            ControllerSessionError::Torque { .. } => CallFailure::misuse(error),
            ControllerSessionError::Interrupted => CallFailure::new(BIPED_STOPPED, "stopped by biped_stop"),
        }
    }
}

thread_local! {
    static LAST: RefCell<CString> = RefCell::default();
}

/// The sentence of this thread's last failure.
pub(crate) fn last() -> *const c_char {
    LAST.try_with(|last| last.borrow().as_ptr()).unwrap_or(c"".as_ptr())
}

/// Runs `what`, and stores the sentence if it fails. A panic becomes a failure. Every function of the library does so.
pub fn guarded(what: impl FnOnce() -> Result<c_int, CallFailure>) -> c_int {
    let defect = || CallFailure::new(BIPED_DEFECT, "a defect of this library; standard error has the details");
    let outcome = catch_unwind(AssertUnwindSafe(what)).unwrap_or_else(|_| Err(defect()));
    outcome.unwrap_or_else(|CallFailure { code, sentence }| {
        let sentence = CString::new(sentence.replace('\0', " ")).unwrap_or_default();
        let _ = LAST.try_with(|last| last.replace(sentence));
        code
    })
}
