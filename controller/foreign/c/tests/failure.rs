//! Claims about the failures of a call.

#![expect(unsafe_code, reason = "a string as C gets it")]

use biped_c::biped_last_error;
use biped_c::failure::{
    BIPED_DEFECT, BIPED_INCOMPATIBLE, BIPED_MISUSE, BIPED_NO_PLANT, BIPED_SHARED_MEMORY, BIPED_STOPPED, guarded,
};
use messages::exit::Exit;
use std::ffi::{CStr, c_int};

#[test]
fn a_panic_becomes_a_code_and_a_sentence() {
    assert_eq!(guarded(|| Ok(1)), 1);
    assert_eq!(guarded(|| panic!("on purpose")), BIPED_DEFECT);
    // SAFETY: the string belongs to this thread and is valid until the next failure.
    assert!(unsafe { CStr::from_ptr(biped_last_error()) }.to_string_lossy().contains("defect"));
}

#[test]
fn every_code_is_minus_the_exit_code_for_the_same_failure() {
    let pairs = [
        (BIPED_MISUSE, Exit::Usage),
        (BIPED_NO_PLANT, Exit::PeerMissing),
        (BIPED_DEFECT, Exit::Fault),
        (BIPED_INCOMPATIBLE, Exit::Incompatible),
        (BIPED_SHARED_MEMORY, Exit::SharedMemory),
        (BIPED_STOPPED, Exit::Interrupted),
    ];
    for (code, exit) in pairs {
        assert_eq!(code, -c_int::from(exit as u8), "{exit:?}");
    }
}
