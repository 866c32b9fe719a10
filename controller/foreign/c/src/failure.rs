//! What may go wrong: a code below zero, and a sentence. Minus the code is the exit code that `biped` itself would end with.

use messages::peer_environment::PeerEnvironmentError;
use messages::port::PortError;
use std::cell::RefCell;
use std::ffi::{CString, c_char, c_int};
use std::panic::{AssertUnwindSafe, catch_unwind};

/// Wrong arguments, calls in a wrong order, or an environment that is not `biped run`'s.
pub const BIPED_MISUSE: c_int = -2;
/// No plant sent sensors.
pub const BIPED_NO_PLANT: c_int = -3;
/// A robot for which `biped_plan` knows no torques, or a defect of this library.
pub const BIPED_DEFECT: c_int = -4;
/// The session has another contract, or a controller already.
pub const BIPED_INCOMPATIBLE: c_int = -5;
/// Shared memory is missing, full or blocked.
pub const BIPED_SHARED_MEMORY: c_int = -6;
/// `biped_stop` was called.
pub const BIPED_STOPPED: c_int = -130;

/// A code and a sentence.
#[derive(Debug, PartialEq)]
pub struct Failure {
    code: c_int,
    sentence: String,
}

impl Failure {
    /// With a code from above.
    pub fn new(code: c_int, sentence: impl ToString) -> Failure {
        Failure { code, sentence: sentence.to_string() }
    }

    /// The caller's mistake.
    pub fn misuse(sentence: impl ToString) -> Failure {
        Failure::new(BIPED_MISUSE, sentence)
    }
}

impl From<PortError> for Failure {
    fn from(error: PortError) -> Failure {
        let code = match &error {
            PortError::SessionName { .. } => BIPED_MISUSE,
            PortError::Incompatible { .. } | PortError::Foreign { .. } | PortError::Taken { .. } => BIPED_INCOMPATIBLE,
            PortError::NoSession { .. } | PortError::Absent { .. } => BIPED_NO_PLANT,
            PortError::SharedMemory(_) => BIPED_SHARED_MEMORY,
        };
        Failure::new(code, error)
    }
}

impl From<PeerEnvironmentError> for Failure {
    fn from(error: PeerEnvironmentError) -> Failure {
        match error {
            PeerEnvironmentError::Malformed(sentence) => Failure::misuse(sentence),
            PeerEnvironmentError::Port(error) => error.into(),
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

/// Does it; keeps the sentence if it fails. A panic goes no further.
pub(crate) fn guarded(what: impl FnOnce() -> Result<c_int, Failure>) -> c_int {
    let defect = || Failure::new(BIPED_DEFECT, "a defect of this library, told on standard error");
    let outcome = catch_unwind(AssertUnwindSafe(what)).unwrap_or_else(|_| Err(defect()));
    outcome.unwrap_or_else(|Failure { code, sentence }| {
        let sentence = CString::new(sentence.replace('\0', " ")).unwrap_or_default();
        let _ = LAST.try_with(|last| last.replace(sentence));
        code
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::ffi::CStr;

    #[test]
    fn a_panic_becomes_a_code_and_a_sentence() {
        assert_eq!(guarded(|| Ok(1)), 1);
        assert_eq!(guarded(|| panic!("on purpose")), BIPED_DEFECT);
        // SAFETY: of this thread, before the next failure.
        assert!(unsafe { CStr::from_ptr(last()) }.to_string_lossy().contains("defect"));
    }
}
