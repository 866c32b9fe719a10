//! The controller as a process: the only file of this crate that uses a clock, another process and a stop request.

use crate::error::ControllerError;
use crate::tick::Controller;
use messages::clock::{Timeout, now_ns, random};
use messages::port::{Action, ControllerPort, PortError, Verdict};
use messages::scene::Scene;
use messages::wire::{Command, Reply, Request, Sensors, Stamp, Stamped};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Why a controller process ended before it received the plant's goodbye.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The connection could not be opened, or it failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The controller does not fit the scene, or it has no torques for the posture of the robot.
    #[error("controller: {0}")]
    Controller(#[from] ControllerError),
    /// No plant sent sensors.
    #[error("no plant sent sensors within {0:?}")]
    NoPlant(Duration),
    /// Ctrl-C or SIGTERM.
    #[error("interrupted")]
    Interrupted,
}

/// Answers the sensors of the plant at the other end of `port` until its goodbye. A new run number starts a new controller.
/// Sensors that arrive a second time get the same answer.
///
/// # Errors
/// See [`ProcessError`].
pub fn run(scene: &Scene, mut port: ControllerPort, patience: Duration, stop: &AtomicBool) -> Result<(), ProcessError> {
    let mut controller = Controller::new(scene)?;
    let mut waiting = Timeout::new("plant", patience);
    let mut answer = Command { stamp: Stamp { epoch: random(), ..Stamp::default() }, ..Command::default() };
    while !stop.load(Relaxed) {
        while let Some(pending) = port.next_request()? {
            let reply = serve_request(&mut controller, &pending.request, &answer.stamp);
            port.answer(pending, reply)?;
        }
        let Some(sensors) = port.wait()?.filter(Sensors::is_sound) else {
            match waiting.has_expired() {
                true => return Err(ProcessError::NoPlant(patience)),
                false => continue,
            }
        };
        if sensors.last != 0 {
            return Ok(());
        }
        let asked = sensors.stamp;
        if answer.stamp.run != asked.run {
            if answer.stamp.run != 0 {
                controller = Controller::new(scene)?; // before the first run it is new, and may have been given other set-points
            }
            answer.stamp = Stamp { run: asked.run, seq: 0, ack: 0, ..answer.stamp };
        }
        if answer.stamp.ack != asked.seq {
            answer.torques = controller.tick(&sensors.encoders)?;
            answer.telemetry = controller.telemetry();
        }
        let seq = answer.stamp.seq + 1;
        answer.stamp = Stamp { seq, ack: asked.seq, sim_ns: asked.sim_ns, mono_ns: now_ns(), ..answer.stamp };
        port.send(answer)?;
        waiting.restart();
    }
    Err(ProcessError::Interrupted)
}

/// Carries out a request. The controller accepts one kind: new set-points of the gait.
fn serve_request(controller: &mut Controller, request: &Request, stamp: &Stamp) -> Reply {
    let verdict = match Action::decode(request) {
        Ok(Action::Set { period, speed }) if controller.set(period, speed).is_ok() => Verdict::Done,
        Ok(Action::Set { .. }) => Verdict::OutOfRange,
        Ok(_) => Verdict::WrongProcess,
        Err(verdict) => verdict,
    };
    Reply { stamp: *stamp, verdict: verdict as u64, state: 0 }
}
