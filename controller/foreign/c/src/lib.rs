//! A controller's end of a session for C, and for whatever speaks to C: [`messages::port`] behind ten functions.
//!
//! `controller.h` is made of this file. Whoever calls gets a code and a sentence, never a panic: see [`failure`].

#![allow(unsafe_code, reason = "pointers from C")]
#![deny(clippy::undocumented_unsafe_blocks)]

pub mod end;
pub mod failure;

use end::Controller;
use failure::{Failure, guarded};
use messages::wire::{Encoders, Telemetry, Torques};
use std::ffi::{CStr, c_char, c_int};
use std::sync::atomic::Ordering::Relaxed;
use std::time::Duration;

/// Said by `biped_wait`: the plant's goodbye, which wants no answer.
pub const BIPED_GOODBYE: c_int = 0;
/// Said by `biped_wait`: encoders are there, torques are wanted.
pub const BIPED_TICK: c_int = 1;
/// Said by `biped_wait`: the same, and they are the first of a run: forget what was before.
pub const BIPED_BEGIN: c_int = 2;

/// Where the session is, and what a controller needs to know of its robot.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Status {
    /// Number of the plant's run; 0 before the first encoders came.
    pub run: u64,
    /// Number of the newest encoders in that run, from 1.
    pub seq: u64,
    /// Their simulated time [s].
    pub time: f64,
    /// Control periods in a second [Hz].
    pub rate: f64,
    /// Angle of one encoder count [rad].
    pub count: f64,
    /// Greatest torque that a drive gives [N·m].
    pub torque_limit: f64,
    /// Joint angles at time zero [rad].
    pub start: [f64; 8],
}

/// Takes the controller's place in the session that `biped run --controller` put into the environment; or, if there is
/// only BIPED_SESSION, attaches to the session of that name, as `biped_attach` does.
///
/// # Safety
/// `controller` is null or points to a pointer that may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_open(controller: *mut *mut Controller) -> c_int {
    guarded(|| {
        let place = there(controller, "biped_open: controller")?;
        let opened = Box::into_raw(Box::new(Controller::open()?));
        // SAFETY: not null; the caller lets us write there.
        unsafe { place.write(opened) };
        Ok(0)
    })
}

/// Takes the controller's place in the session of this name, which `biped plant SCENE --session NAME` has started, or will
/// within `patience` seconds. Sensors may be missing for as long.
///
/// # Safety
/// `controller` is null or points to a pointer that may be written; `session` is null or ends with a zero.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_attach(
    controller: *mut *mut Controller,
    session: *const c_char,
    patience: f64,
) -> c_int {
    guarded(|| {
        let place = there(controller, "biped_attach: controller")?;
        let session = there(session.cast_mut(), "biped_attach: session")?;
        // SAFETY: not null; the caller promises that it ends with a zero.
        let session = unsafe { CStr::from_ptr(session) }.to_string_lossy();
        let patience = Duration::try_from_secs_f64(patience)
            .map_err(|error| Failure::misuse(format!("biped_attach: patience is {patience} s: {error}")))?;
        let opened = Box::into_raw(Box::new(Controller::attach(&session, patience)?));
        // SAFETY: not null; the caller lets us write there.
        unsafe { place.write(opened) };
        Ok(0)
    })
}

/// Waits for encoders that have not been answered: BIPED_GOODBYE, BIPED_TICK or BIPED_BEGIN. What the plant asks again is
/// answered again by itself.
///
/// # Safety
/// `controller` is null or from `biped_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_wait(controller: *mut Controller) -> c_int {
    // SAFETY: as the caller promises.
    guarded(|| unsafe { opened(controller) }?.wait())
}

/// The encoders that `biped_wait` found.
///
/// # Safety
/// `controller` is null or from `biped_open`; `encoders` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_read(controller: *mut Controller, encoders: *mut Encoders) -> c_int {
    guarded(|| {
        let place = there(encoders, "biped_read: encoders")?;
        // SAFETY: as the caller promises.
        let found = unsafe { opened(controller) }?.encoders()?;
        // SAFETY: not null; the caller lets us write there.
        unsafe { place.write(found) };
        Ok(0)
    })
}

/// What this project's own controller, in Rust, would answer to them, and what it thinks; telemetry may be NULL. Once for
/// each `biped_wait`, if at all: a place to begin from, or to add to.
///
/// # Safety
/// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_plan(
    controller: *mut Controller,
    torques: *mut Torques,
    telemetry: *mut Telemetry,
) -> c_int {
    guarded(|| {
        let place = there(torques, "biped_plan: torques")?;
        // SAFETY: as the caller promises.
        let (planned, thought) = unsafe { opened(controller) }?.plan()?;
        // SAFETY: not null; the caller lets us write there.
        unsafe { place.write(planned) };
        if !telemetry.is_null() {
            // SAFETY: the same.
            unsafe { telemetry.write(thought) };
        }
        Ok(0)
    })
}

/// Answers them by torques; telemetry may be NULL. Once for each `biped_wait`.
///
/// # Safety
/// `controller` is null or from `biped_open`; `torques` and `telemetry` are null or may be read.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_write(
    controller: *mut Controller,
    torques: *const Torques,
    telemetry: *const Telemetry,
) -> c_int {
    guarded(|| {
        let torques = there(torques.cast_mut(), "biped_write: torques")?;
        // SAFETY: not null; the caller lets us read there, and every pattern of bits is such a message.
        let torques = unsafe { torques.read() };
        // SAFETY: the same, if it is not null.
        let telemetry = (!telemetry.is_null()).then(|| unsafe { telemetry.read() });
        // SAFETY: as the caller promises.
        unsafe { opened(controller) }?.answer(torques, telemetry.unwrap_or_default())?;
        Ok(0)
    })
}

/// Where the session is.
///
/// # Safety
/// `controller` is null or from `biped_open`; `status` is null or may be written.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_status(controller: *mut Controller, status: *mut Status) -> c_int {
    guarded(|| {
        let place = there(status, "biped_status: status")?;
        // SAFETY: as the caller promises.
        let found = unsafe { opened(controller) }?.status();
        // SAFETY: not null; the caller lets us write there.
        unsafe { place.write(found) };
        Ok(0)
    })
}

/// Leaves the session, and makes the pointer NULL.
///
/// # Safety
/// `controller` is null or points to a pointer that is null or from `biped_open`.
#[unsafe(no_mangle)]
pub unsafe extern "C" fn biped_close(controller: *mut *mut Controller) -> c_int {
    guarded(|| {
        let place = there(controller, "biped_close: controller")?;
        // SAFETY: not null; the caller lets us read and write there, and what it points to is as it promises.
        unsafe {
            let controller: *mut Controller = opened(*place)?;
            *place = std::ptr::null_mut();
            drop(Box::from_raw(controller));
        }
        Ok(0)
    })
}

/// Makes `biped_wait` return, now and later: `signal(SIGTERM, biped_stop)` ends a controller in order.
#[unsafe(no_mangle)]
pub extern "C" fn biped_stop(signal: c_int) {
    let _ = signal; // one is as good as another
    end::STOP.store(true, Relaxed);
}

/// What the last call of this thread that failed has to say, until the next one fails: a sentence, never NULL.
#[unsafe(no_mangle)]
pub extern "C" fn biped_last_error() -> *const c_char {
    failure::last()
}

/// What is not null.
fn there<T>(pointer: *mut T, what: &str) -> Result<*mut T, Failure> {
    match pointer.is_null() {
        true => Err(Failure::misuse(format!("{what} is NULL"))),
        false => Ok(pointer),
    }
}

/// What `biped_open` gave, in the thread to which it gave it.
///
/// # Safety
/// `controller` is null or from `biped_open`, not closed, and nobody else uses it during the call.
unsafe fn opened<'a>(controller: *mut Controller) -> Result<&'a mut Controller, Failure> {
    let controller = there(controller, "the controller, not open or closed already,")?;
    // SAFETY: not null, and from `Box::into_raw`.
    let controller = unsafe { &mut *controller };
    controller
        .is_ours()
        .then_some(controller)
        .ok_or_else(|| Failure::misuse("a controller is for the thread that opened it"))
}
