//! The controller's side of a session, for a controller of one's own: each reading of the encoders once, and one answer to each.
//!
//! ```no_run
//! use biped_messages::controller_session::ControllerSession;
//! use biped_messages::wire::{Telemetry, Torques};
//! use std::sync::atomic::AtomicBool;
//!
//! static STOP: AtomicBool = AtomicBool::new(false); // true ends `wait`
//! let (mut session, scene) = ControllerSession::join(None, &STOP)?; // the session that the environment names
//! while let Some(reading) = session.wait(&STOP)? {
//!     let torques = Torques { torque: [0.0; 8] }; // from reading.encoders and the scene
//!     session.answer(torques, Telemetry::default())?;
//! }
//! # Ok::<(), biped_messages::controller_session::ControllerSessionError>(())
//! ```

use crate::action::GaitRequest;
use crate::clock::{Timeout, now_ns, random};
use crate::exit::Exit;
use crate::peer_environment::{PeerEnvironment, PeerEnvironmentError};
use crate::port::{ControllerPort, PortError, Verdict};
use crate::scene::Scene;
use crate::wire::{Command, Encoders, Sensors, Stamp, Stamped, Telemetry, Torques};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// Time for which [`ControllerSession::join`] waits for a session that is named to it.
const PATIENCE: Duration = Duration::from_secs(10);

/// A controller in a session.
#[derive(Debug)]
pub struct ControllerSession {
    port: ControllerPort,
    /// Stamp of the last reading; its number is 0 before the first one.
    asked: Stamp,
    answer: Command,
    waiting: Timeout,
    patience: Duration,
    /// Whether the program answers requests.
    serves: bool,
}

/// A reading of the encoders that needs an answer.
#[derive(Clone, Copy, Debug, Default)]
pub struct Reading {
    /// Stamp of the sensors, with run, number and simulated time.
    pub stamp: Stamp,
    /// Encoder counts of all joints.
    pub encoders: Encoders,
    /// Whether this is the first reading of a run. The controller must then start from its initial state.
    pub begins: bool,
}

/// Result of [`ControllerSession::poll`].
#[derive(Clone, Copy, Debug)]
pub enum Event {
    /// No new reading for some milliseconds.
    Idle,
    /// A new reading.
    Reading(Reading),
    /// The plant's goodbye, which needs no answer.
    Goodbye,
}

/// Reason why a controller left its session before the plant's goodbye.
#[derive(Debug, thiserror::Error)]
pub enum ControllerSessionError {
    /// The environment does not describe a session, or there is no such session.
    #[error(transparent)]
    Environment(#[from] PeerEnvironmentError),
    /// The connection could not be opened, or it failed.
    #[error(transparent)]
    Port(#[from] PortError),
    /// No plant sent sensors.
    #[error("no plant sent sensors within {patience} s", patience = crate::legible(.0.as_secs_f64()))]
    NoPlant(Duration),
    /// A torque is not finite.
    #[error("torque[{joint}] is {torque}: torques must be finite")]
    Torque {
        /// Index of the joint.
        joint: usize,
        /// Torque as given [N·m].
        torque: f64,
    },
    /// Ctrl-C or SIGTERM.
    #[error("interrupted")]
    Interrupted,
}

impl ControllerSessionError {
    /// The exit code with which a controller process ends.
    pub fn exit_code(&self) -> Exit {
        match self {
            Self::Environment(PeerEnvironmentError::Malformed(_)) | Self::Torque { .. } => Exit::Usage,
            Self::Environment(PeerEnvironmentError::Port(error)) | Self::Port(error) => error.exit_code(),
            Self::NoPlant(_) => Exit::PeerMissing,
            Self::Interrupted => Exit::Interrupted,
        }
    }
}

impl ControllerSession {
    /// Joins the session of this name, or else the one that the environment names: see [`PeerEnvironment::from_env`]. Also returns its
    /// scene. It waits for a session that is not there yet, and for a predecessor to leave.
    ///
    /// # Errors
    /// See [`ControllerSessionError`].
    pub fn join(
        session: Option<&str>,
        stop: &AtomicBool,
    ) -> Result<(ControllerSession, Scene), ControllerSessionError> {
        let keeps_waiting = || !stop.load(Relaxed);
        let environment = match session {
            Some(name) => PeerEnvironment::attach(name, PATIENCE, keeps_waiting)?,
            None => PeerEnvironment::from_env(keeps_waiting)?,
        };
        Ok(ControllerSession::enter(environment, keeps_waiting)?)
    }

    /// Joins the session of an environment, and returns its scene. A successor waits for the end of its predecessor while
    /// `keeps_waiting` returns true.
    ///
    /// # Errors
    /// If the session has another contract or another controller, or shared memory fails.
    pub fn enter(
        environment: PeerEnvironment,
        keeps_waiting: impl Fn() -> bool,
    ) -> Result<(ControllerSession, Scene), PortError> {
        let PeerEnvironment { session, contract, patience, scene, takes_over } = environment;
        let port = ControllerPort::open_when_free(&session, &contract, || takes_over && keeps_waiting())?;
        Ok((ControllerSession::over(port, patience), scene))
    }

    /// A controller at an open port that waits at most for `patience` for the plant.
    pub fn over(port: ControllerPort, patience: Duration) -> ControllerSession {
        let answer = Command { stamp: Stamp { epoch: random(), ..Stamp::default() }, ..Command::default() };
        let waiting = Timeout::new("plant", patience);
        ControllerSession { port, asked: Stamp::default(), answer, waiting, patience, serves: false }
    }

    /// Waits for the next reading. `None` is the plant's goodbye.
    ///
    /// # Errors
    /// No plant, `stop`, or a connection that failed.
    pub fn wait(&mut self, stop: &AtomicBool) -> Result<Option<Reading>, ControllerSessionError> {
        self.begin_wait();
        while !stop.load(Relaxed) {
            match self.poll()? {
                Event::Idle => {}
                Event::Reading(reading) => return Ok(Some(reading)),
                Event::Goodbye => return Ok(None),
            }
        }
        Err(ControllerSessionError::Interrupted)
    }

    /// Restarts the time in which the plant must send a reading. A program that may have paused calls this before [`ControllerSession::poll`].
    pub fn begin_wait(&mut self) {
        self.waiting.restart();
    }

    /// Waits for some milliseconds for the next reading. A reading that the plant repeats gets the same answer again.
    ///
    /// # Errors
    /// No plant, or a connection that failed.
    pub fn poll(&mut self) -> Result<Event, ControllerSessionError> {
        if !self.serves {
            self.port.serve(self.answer.stamp, |_| Verdict::NotServed)?;
        }
        let Some(sensors) = self.port.wait()?.filter(Sensors::is_sound) else {
            return match self.waiting.has_expired() {
                true => Err(ControllerSessionError::NoPlant(self.patience)),
                false => Ok(Event::Idle),
            };
        };
        if sensors.last != 0 {
            return Ok(Event::Goodbye);
        }
        let begins = self.answer.stamp.run != sensors.stamp.run;
        if begins {
            self.answer.stamp = Stamp { run: sensors.stamp.run, seq: 0, ack: 0, ..self.answer.stamp };
        } else if self.answer.stamp.ack == sensors.stamp.seq {
            self.send()?;
            return Ok(Event::Idle);
        }
        self.asked = sensors.stamp;
        Ok(Event::Reading(Reading { stamp: sensors.stamp, encoders: sensors.encoders, begins }))
    }

    /// Answers the last reading.
    ///
    /// # Errors
    /// A torque that is not finite, or a connection that failed.
    pub fn answer(&mut self, torques: Torques, telemetry: Telemetry) -> Result<(), ControllerSessionError> {
        if let Some(joint) = torques.torque.iter().position(|torque| !torque.is_finite()) {
            return Err(ControllerSessionError::Torque { joint, torque: torques.torque[joint] });
        }
        (self.answer.torques, self.answer.telemetry) = (torques, telemetry);
        Ok(self.send()?)
    }

    fn send(&mut self) -> Result<(), PortError> {
        let (asked, seq) = (self.asked, self.answer.stamp.seq + 1);
        self.answer.stamp = Stamp { seq, ack: asked.seq, sim_ns: asked.sim_ns, mono_ns: now_ns(), ..self.answer.stamp };
        self.waiting.restart();
        self.port.send(self.answer)
    }

    /// Answers requests of `biped set` by the verdict of `answer`. Call this before each [`ControllerSession::poll`]. Requests to a controller
    /// that never calls it are refused.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn serve(&mut self, answer: impl FnMut(GaitRequest) -> Verdict) -> Result<(), PortError> {
        self.serves = true;
        self.port.serve(self.answer.stamp, answer)
    }
}
