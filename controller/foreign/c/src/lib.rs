//! The controller's end of a session for C, and for every language that can call C: [`messages::port`] behind ten functions.
//!
//! `controller.h` is generated from this crate. A call that fails returns a code and stores a sentence; it never panics: see
//! [`failure`].

#![allow(unsafe_code, reason = "pointers from C")]
#![deny(clippy::undocumented_unsafe_blocks)]

pub mod end;
pub mod failure;
pub mod status;

use end::ControllerHandle;
use failure::{CallFailure, guarded};
use messages::wire::{Encoders, Telemetry, Torques};
use status::ControllerStatus;
use std::ffi::{CStr, c_char, c_int};
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Joins a session as its controller. `biped run --controller` names the session in the environment. If the
/// environment has only BIPED_SESSION, this attaches to the session of that name, as `biped_attach` does.
///
/// # Safety
/// `controller` is null or points to a pointer that may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_open(controller: *mut *mut ControllerHandle) -> c_int {
    guarded(|| {
        let target = not_null(controller, "biped_open: controller")?;
        let opened = Box::into_raw(Box::new(ControllerHandle::open()?));
        // SAFETY: not null; the caller allows writing there.
        unsafe { target.write(opened) };
        Ok(0)
    })
}

/// Joins the session of this name as its controller. `biped plant SCENE --session NAME` starts such a session. This waits for it for
/// `patience` seconds, and later as long for sensor messages.
///
/// # Safety
/// `controller` is null or points to a pointer that may be written; `session` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_attach(
    controller: *mut *mut ControllerHandle,
    session: *const c_char,
    patience: f64,
) -> c_int {
    guarded(|| {
        let target = not_null(controller, "biped_attach: controller")?;
        let session = not_null(session.cast_mut(), "biped_attach: session")?;
        // SAFETY: not null; the caller promises that it ends with a zero.
        let session = unsafe { CStr::from_ptr(session) }.to_string_lossy();
        let patience = Duration::try_from_secs_f64(patience)
            .map_err(|error| CallFailure::misuse(format!("biped_attach: patience is {patience} s: {error}")))?;
        let opened = Box::into_raw(Box::new(ControllerHandle::attach(&session, patience)?));
        // SAFETY: not null; the caller allows writing there.
        unsafe { target.write(opened) };
        Ok(0)
    })
}

/// Waits for a reading of the encoders that has not been answered: returns BIPED_GOODBYE, BIPED_TICK or BIPED_BEGIN. If the plant
/// repeats a reading, this function repeats the answer.
///
/// # Safety
/// `controller` is null or from `biped_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_wait(controller: *mut ControllerHandle) -> c_int {
    // SAFETY: as the caller promises.
    guarded(|| unsafe { opened(controller) }?.wait_until_stopped())
}

/// The reading of the encoders that `biped_wait` has received.
///
/// # Safety
/// `controller` is null or from `biped_open`; `encoders` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_read(controller: *mut ControllerHandle, encoders: *mut Encoders) -> c_int {
    guarded(|| {
        let target = not_null(encoders, "biped_read: encoders")?;
        // SAFETY: as the caller promises.
        let found = unsafe { opened(controller) }?.encoders()?;
        // SAFETY: not null; the caller allows writing there.
        unsafe { target.write(found) };
        Ok(0)
    })
}

/// The torques and the telemetry of this project's own controller for this reading; telemetry may be NULL. Call it at most once for
/// each `biped_wait`. It can be a starting point for your own control law.
///
/// # Safety
/// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_plan(
    controller: *mut ControllerHandle,
    torques: *mut Torques,
    telemetry: *mut Telemetry,
) -> c_int {
    guarded(|| {
        let target = not_null(torques, "biped_plan: torques")?;
        // SAFETY: as the caller promises.
        let (planned, state) = unsafe { opened(controller) }?.plan()?;
        // SAFETY: not null; the caller allows writing there.
        unsafe { target.write(planned) };
        if !telemetry.is_null() {
            // SAFETY: the same.
            unsafe { telemetry.write(state) };
        }
        Ok(0)
    })
}

/// Answers the reading with torques; telemetry may be NULL. Call it once for each `biped_wait`.
///
/// # Safety
/// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_write(
    controller: *mut ControllerHandle,
    torques: *const Torques,
    telemetry: *const Telemetry,
) -> c_int {
    guarded(|| {
        let torques = not_null(torques.cast_mut(), "biped_write: torques")?;
        // SAFETY: not null; the caller allows reading there, and every bit pattern is a valid message.
        let torques = unsafe { torques.read() };
        // SAFETY: the same, if it is not null.
        let telemetry = (!telemetry.is_null()).then(|| unsafe { telemetry.read() });
        // SAFETY: as the caller promises.
        unsafe { opened(controller) }?.answer(torques, telemetry.unwrap_or_default())?;
        Ok(0)
    })
}

/// The state of the session.
///
/// # Safety
/// `controller` is null or from `biped_open`; `status` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_status(controller: *mut ControllerHandle, status: *mut ControllerStatus) -> c_int {
    guarded(|| {
        let target = not_null(status, "biped_status: status")?;
        // SAFETY: as the caller promises.
        let found = unsafe { opened(controller) }?.status();
        // SAFETY: not null; the caller allows writing there.
        unsafe { target.write(found) };
        Ok(0)
    })
}

/// Leaves the session and sets the pointer to NULL.
///
/// # Safety
/// `controller` is null or points to a pointer that is null or from `biped_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_close(controller: *mut *mut ControllerHandle) -> c_int {
    guarded(|| {
        let target = not_null(controller, "biped_close: controller")?;
        // SAFETY: not null; the caller allows reading and writing there, and promises that it points to such a pointer.
        unsafe {
            let controller: *mut ControllerHandle = opened(*target)?;
            *target = std::ptr::null_mut();
            drop(Box::from_raw(controller));
        }
        Ok(0)
    })
}

/// Makes this and every later call of `biped_wait` return BIPED_STOPPED. With `signal(SIGTERM, biped_stop)` a controller ends cleanly.
#[unsafe(no_mangle)]
pub extern "C" fn biped_stop(signal: c_int) {
    let _ = signal; // every signal has the same effect
    end::STOP.store(true, Relaxed);
}

/// The sentence of the last call of this thread that failed; it is valid until the next failure. Never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn biped_last_error() -> *const c_char {
    failure::last()
}

/// Checks that a pointer is not null.
fn not_null<T>(pointer: *mut T, what: &str) -> Result<*mut T, CallFailure> {
    match pointer.is_null() {
        true => Err(CallFailure::misuse(format!("{what} is NULL"))),
        false => Ok(pointer),
    }
}

/// The controller behind a pointer of `biped_open`, in the thread that opened it.
///
/// # Safety
/// `controller` is null or from `biped_open`, not closed, and not used by another call at the same time.
unsafe fn opened<'a>(controller: *mut ControllerHandle) -> Result<&'a mut ControllerHandle, CallFailure> {
    let controller = not_null(controller, "the controller is not open, or it is closed already: the pointer")?;
    // SAFETY: not null, and from `Box::into_raw`.
    let controller = unsafe { &mut *controller };
    controller
        .is_ours()
        .then_some(controller)
        .ok_or_else(|| CallFailure::misuse("a controller can only be used by the thread that opened it"))
}
