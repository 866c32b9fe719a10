//! The controller's end of a session in safe Rust: a [`ControllerSession`] whose calls are checked for their order.

use crate::failure::{BIPED_DEFECT, CallFailure};
use crate::status::{BIPED_BEGIN, BIPED_GOODBYE, BIPED_TICK, ControllerStatus};
use controller::{Controller as Planner, ControllerError};
use messages::controller_session::{ControllerSession, ControllerSessionError, Event, Reading};
use messages::peer_environment::PeerEnvironment;
use messages::port::{GaitRequest, Verdict};
use messages::scene::Scene;
use messages::wire::{Encoders, Stamp, Telemetry, Torques};
use std::ffi::c_int;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::ThreadId;
use std::time::Duration;

/// Whether `biped_stop` has been called.
pub(crate) static STOP: AtomicBool = AtomicBool::new(false);

/// Number of the run, number of the last sensors, and the controller.
type Walker = (u64, u64, Box<Planner>);

/// A controller in a session.
pub struct ControllerHandle {
    session: ControllerSession,
    /// The last reading; its number is 0 before the first one.
    reading: Reading,
    is_answered: bool,
    /// The constant part of the status.
    robot: ControllerStatus,
    scene: Scene,
    /// This project's own controller, after the first call of `biped_plan`.
    walker: Option<Walker>,
    owner: ThreadId,
}

impl ControllerHandle {
    /// Joins the session that the environment names.
    pub(crate) fn open() -> Result<ControllerHandle, CallFailure> {
        ControllerHandle::join(PeerEnvironment::from_env(|| !STOP.load(Relaxed))?, || !STOP.load(Relaxed))
    }

    /// Joins a session by its name, once it is running.
    pub(crate) fn attach(session: &str, patience: Duration) -> Result<ControllerHandle, CallFailure> {
        let keeps_waiting = || !STOP.load(Relaxed);
        ControllerHandle::join(PeerEnvironment::attach(session, patience, keeps_waiting)?, keeps_waiting)
    }

    /// Joins the session of an environment. A successor waits for the end of its predecessor while `keeps_waiting` returns true.
    ///
    /// # Errors
    /// If the session has another contract or another controller, or shared memory fails.
    pub fn join(
        environment: PeerEnvironment,
        keeps_waiting: impl Fn() -> bool,
    ) -> Result<ControllerHandle, CallFailure> {
        let (session, scene) = ControllerSession::enter(environment, keeps_waiting)?;
        Ok(ControllerHandle {
            session,
            reading: Reading::default(),
            is_answered: true,
            robot: robot(&scene),
            scene,
            walker: None,
            owner: std::thread::current().id(),
        })
    }

    /// Whether this is the thread that opened it.
    pub(crate) fn is_ours(&self) -> bool {
        self.owner == std::thread::current().id()
    }

    /// As [`ControllerHandle::wait`], until `biped_stop` is called. Requests to the gait are for the controller of `biped_plan`.
    pub(crate) fn wait_until_stopped(&mut self) -> Result<c_int, CallFailure> {
        let mut walker = self.walker.take();
        let answer = |request| match &mut walker {
            Some((.., planner)) => planner.answer(request),
            None => Verdict::NotServed,
        };
        let outcome = self.wait(|| !STOP.load(Relaxed), answer);
        self.walker = walker;
        outcome
    }

    /// Waits for the next sensors while `keeps_waiting` returns true, and returns their kind. It is asked every 10 ms. Meanwhile it answers
    /// requests to the gait by the verdict of `answer`.
    ///
    /// # Errors
    /// If no plant sends sensors in time, or the wait is stopped.
    pub fn wait(
        &mut self,
        mut keeps_waiting: impl FnMut() -> bool,
        mut answer: impl FnMut(GaitRequest) -> Verdict,
    ) -> Result<c_int, CallFailure> {
        self.session.begin_wait();
        while keeps_waiting() {
            self.session.serve(&mut answer)?;
            match self.session.poll()? {
                Event::Idle => {}
                Event::Reading(reading) => {
                    (self.reading, self.is_answered) = (reading, false);
                    return Ok(if reading.begins { BIPED_BEGIN } else { BIPED_TICK });
                }
                Event::Goodbye => {
                    self.is_answered = true;
                    return Ok(BIPED_GOODBYE);
                }
            }
        }
        Err(ControllerSessionError::Interrupted.into())
    }

    /// Torques and telemetry of this project's own controller. It must get every reading of a run exactly once.
    pub(crate) fn plan(&mut self) -> Result<(Torques, Telemetry), CallFailure> {
        if self.is_answered {
            return Err(CallFailure::misuse("there is no reading to answer: call biped_wait, then biped_plan once"));
        }
        let fault = |error: ControllerError| {
            CallFailure::new(BIPED_DEFECT, format!("biped_plan has no torques for this robot: {error}"))
        };
        let Stamp { run, seq, .. } = self.reading.stamp;
        let walker = match self.walker.take().filter(|(of, ..)| *of == run) {
            Some(walker) => self.walker.insert(walker),
            None => {
                let mut planner = Box::new(Planner::new(&self.scene).map_err(fault)?);
                planner.begin_at(self.reading.stamp.time());
                self.walker.insert((run, 0, planner))
            }
        };
        if std::mem::replace(&mut walker.1, seq) == seq {
            return Err(CallFailure::misuse(
                "biped_plan was already called for this reading: call it once for each biped_wait",
            ));
        }
        let torques = walker.2.tick(&self.reading.encoders).map_err(fault)?;
        Ok((torques, walker.2.telemetry()))
    }

    /// The reading of the encoders.
    ///
    /// # Errors
    /// If there is none yet.
    pub fn encoders(&self) -> Result<Encoders, CallFailure> {
        match self.reading.stamp.seq {
            0 => Err(CallFailure::misuse("there is no reading of the encoders yet: call biped_wait first")),
            _ => Ok(self.reading.encoders),
        }
    }

    /// Answers the last sensors.
    ///
    /// # Errors
    /// If they are answered already, or a torque is not finite.
    pub fn answer(&mut self, torques: Torques, telemetry: Telemetry) -> Result<(), CallFailure> {
        if self.is_answered {
            return Err(CallFailure::misuse("there is no reading to answer: call biped_wait, then biped_write once"));
        }
        self.session.answer(torques, telemetry)?;
        self.is_answered = true;
        Ok(())
    }

    /// State of the session.
    pub fn status(&self) -> ControllerStatus {
        let stamp = self.reading.stamp;
        ControllerStatus { run: stamp.run, seq: stamp.seq, time: stamp.time(), ..self.robot }
    }
}

/// The data of the robot that a controller needs.
fn robot(scene: &Scene) -> ControllerStatus {
    ControllerStatus {
        rate: scene.rate,
        count: scene.plant.radians_per_count(),
        torque_limit: scene.plant.torque_limit,
        start: scene.initial.angles(),
        ..ControllerStatus::default()
    }
}
