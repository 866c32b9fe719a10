//! The controller as a process: the one file of this crate that knows a clock, a peer and a stop request.

use crate::{Controller, ControllerError};
use messages::clock::{Timeout, now_ns, random};
use messages::port::{Action, ControllerPort, PortError, Verdict};
use messages::scene::Scene;
use messages::wire::{Command, Reply, Request, Sensors, Stamp, Stamped};
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
/// new run number, gets a new controller; sensors that come again, the same answer.
///
/// # Errors
/// See [`ProcessError`].
pub fn run(scene: &Scene, mut port: ControllerPort, patience: Duration, stop: &AtomicBool) -> Result<(), ProcessError> {
    let mut controller = Controller::new(scene)?;
    let mut waiting = Timeout::new("plant", patience);
    let mut answer = Command { stamp: Stamp { epoch: random(), ..Stamp::default() }, ..Command::default() };
    while !stop.load(Relaxed) {
        while let Some(asked) = port.next_request()? {
            let reply = serve_request(&mut controller, &asked.request, &answer.stamp);
            port.answer(asked, reply)?;
        }
        let Some(sensors) = port.wait()?.filter(Sensors::is_sound) else {
            match waiting.is_over() {
                true => return Err(ProcessError::NoPlant(patience)),
                false => continue,
            }
        };
        if sensors.last != 0 {
            return Ok(());
        }
        let asked = sensors.stamp;
        if answer.stamp.run != asked.run {
            controller = Controller::new(scene)?;
            answer.stamp = Stamp { run: asked.run, seq: 0, ack: 0, ..answer.stamp };
        }
        if answer.stamp.ack != asked.seq {
            answer.torques = controller.tick(&sensors.encoders)?;
            answer.telemetry = controller.telemetry();
        }
        let seq = answer.stamp.seq + 1;
        answer.stamp = Stamp { seq, ack: asked.seq, sim_ns: asked.sim_ns, mono_ns: now_ns(), ..answer.stamp };
        port.send(answer)?;
        waiting.renew();
    }
    Err(ProcessError::Interrupted)
}

/// Gait set-points, the one thing that this desk does.
fn serve_request(controller: &mut Controller, request: &Request, stamp: &Stamp) -> Reply {
    let verdict = match Action::decode(request) {
        Ok(Action::Set { period, speed }) if controller.set(period, speed).is_ok() => Verdict::Done,
        Ok(Action::Set { .. }) => Verdict::OutOfRange,
        Ok(_) => Verdict::WrongProcess,
        Err(verdict) => verdict,
    };
    Reply { stamp: *stamp, verdict: verdict as u64, state: 0 }
}
