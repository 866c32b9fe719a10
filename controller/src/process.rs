//! The controller as a process: the only file of this crate that uses a clock, another process and a stop request.

use crate::error::ControllerError;
use crate::tick::Controller;
use messages::controller_session::{ControllerSession, ControllerSessionError, Event};
use messages::port::ControllerPort;
use messages::scene::Scene;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Why a controller process ended before it received the plant's goodbye.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// No plant, no connection, or a request to stop.
    #[error(transparent)]
    Session(#[from] ControllerSessionError),
    /// The controller does not fit the scene, or it has no torques for the posture of the robot.
    #[error("controller: {0}")]
    Controller(#[from] ControllerError),
}

/// Answers the sensors of the plant at the other end of `port` until its goodbye. A new run starts a new controller.
///
/// # Errors
/// See [`ProcessError`].
pub fn run(scene: &Scene, port: ControllerPort, patience: Duration, stop: &AtomicBool) -> Result<(), ProcessError> {
    let mut controller = Controller::new(scene)?;
    let mut session = ControllerSession::over(port, patience);
    let mut has_run = false;
    while !stop.load(Relaxed) {
        session.serve(|request| controller.answer(request)).map_err(ControllerSessionError::from)?;
        match session.poll()? {
            Event::Idle => {}
            Event::Goodbye => return Ok(()),
            Event::Reading(reading) => {
                if reading.begins && has_run {
                    controller = Controller::new(scene)?; // before the first run it is new, and may have another gait by request
                }
                if reading.begins {
                    controller.begin_at(reading.stamp.time());
                }
                has_run = true;
                session.answer(controller.tick(&reading.encoders)?, controller.telemetry())?;
            }
        }
    }
    Err(ControllerSessionError::Interrupted.into())
}
