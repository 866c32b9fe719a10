//! The controller as a process: the one file of this crate that knows a clock, a peer and a stop request.

use crate::{Controller, ControllerError};
use messages::clock::{Patience, now_ns, random};
use messages::port::{ControllerPort, PortError};
use messages::scene::Scene;
use messages::wire::{Command, Stamp};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Why a controller process ended before the plant's goodbye.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The link cannot be made or broke.
    #[error(transparent)]
    Port(#[from] PortError),
    /// No controller for this scene, or none for this posture.
    #[error("controller: {0}")]
    Controller(#[from] ControllerError),
    /// Nobody sent sensors.
    #[error("no plant sent sensors within {0:?}")]
    NoPlant(Duration),
    /// Ctrl-C or TERM.
    #[error("interrupted")]
    Interrupted,
}

/// Answers the plant at the other end of `port`, tick by tick, until it says goodbye. A plant that starts anew, with a
/// new run number, gets a new controller.
///
/// # Errors
/// See [`ProcessError`].
pub fn run(scene: &Scene, mut port: ControllerPort, patience: Duration, stop: &AtomicBool) -> Result<(), ProcessError> {
    let mut controller = Controller::new(scene)?;
    let mut waiting = Patience::new("plant", patience);
    let mut stamp = Stamp { epoch: random(), ..Stamp::default() };
    while !stop.load(Relaxed) {
        let Some(sensors) = port.wait()? else {
            match waiting.is_over() {
                true => return Err(ProcessError::NoPlant(patience)),
                false => continue,
            }
        };
        if sensors.last != 0 {
            return Ok(());
        }
        if stamp.run != sensors.stamp.run {
            controller = Controller::new(scene)?;
            stamp = Stamp { run: sensors.stamp.run, seq: 0, ..stamp };
        }
        let torques = controller.tick(&sensors.encoders)?;
        stamp.seq += 1;
        stamp = Stamp { ack: sensors.stamp.seq, sim_ns: sensors.stamp.sim_ns, mono_ns: now_ns(), ..stamp };
        port.send(Command { stamp, torques, telemetry: controller.telemetry() })?;
        waiting.renew();
    }
    Err(ProcessError::Interrupted)
}
