//! The controller's end of a session, in plain Rust: the manners of docs/WIRE.md around a [`ControllerPort`].

use crate::failure::{BIPED_DEFECT, BIPED_NO_PLANT, BIPED_STOPPED, Failure};
use crate::{BIPED_BEGIN, BIPED_GOODBYE, BIPED_TICK, Status};
use controller::{Controller as Planner, ControllerError};
use messages::clock::{Timeout, now_ns, random};
use messages::peer_environment::PeerEnvironment;
use messages::port::{ControllerPort, PortError};
use messages::scene::Scene;
use messages::wire::{Command, Encoders, Sensors, Stamp, Stamped, Telemetry, Torques};
use std::f64::consts::TAU;
use std::ffi::c_int;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::thread::ThreadId;
use std::time::Duration;

/// Whether somebody wants an end.
pub(crate) static STOP: AtomicBool = AtomicBool::new(false);

/// Run, number of the sensors seen last, and the controller.
type Walker = (u64, u64, Box<Planner>);

/// A controller's place in a session.
pub struct Controller {
    port: ControllerPort,
    /// What came last; number 0 before anything came.
    sensors: Sensors,
    answer: Command,
    is_answered: bool,
    patience: Duration,
    /// What does not change of it.
    robot: Status,
    scene: Scene,
    /// This project's own controller, once it has been asked, and the number of the sensors that it has seen.
    walker: Option<Walker>,
    owner: ThreadId,
}

impl Controller {
    /// The place that the environment names.
    pub(crate) fn open() -> Result<Controller, Failure> {
        Controller::of(PeerEnvironment::from_env(|| !STOP.load(Relaxed))?)
    }

    /// The place in a running session, once that is there.
    pub(crate) fn attach(session: &str, patience: Duration) -> Result<Controller, Failure> {
        Controller::of(PeerEnvironment::attach(session, patience, || !STOP.load(Relaxed))?)
    }

    fn of(environment: PeerEnvironment) -> Result<Controller, Failure> {
        let PeerEnvironment { session, contract, patience, scene, takes_over } = environment;
        let waits = || takes_over && !STOP.load(Relaxed);
        Ok(Controller {
            port: ControllerPort::open_when_free(&session, &contract, waits)?,
            sensors: Sensors::default(),
            answer: Command { stamp: Stamp { epoch: random(), ..Stamp::default() }, ..Command::default() },
            is_answered: true,
            patience,
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

    /// The next encoders, and what they are.
    pub(crate) fn wait(&mut self) -> Result<c_int, Failure> {
        let mut waiting = Timeout::new("plant", self.patience);
        while !STOP.load(Relaxed) {
            let Some(sensors) = self.port.wait()?.filter(Sensors::is_sound) else {
                match waiting.has_expired() {
                    true => return Err(self.no_plant()),
                    false => continue,
                }
            };
            if sensors.last != 0 {
                self.is_answered = true;
                return Ok(BIPED_GOODBYE);
            }
            let asked = sensors.stamp;
            let begins = self.answer.stamp.run != asked.run;
            if begins {
                self.answer.stamp = Stamp { run: asked.run, seq: 0, ack: 0, ..self.answer.stamp };
            } else if self.answer.stamp.ack == asked.seq {
                self.send()?; // sensors that come again get the same answer
                continue;
            }
            (self.sensors, self.is_answered) = (sensors, false);
            return Ok(if begins { BIPED_BEGIN } else { BIPED_TICK });
        }
        Err(Failure::new(BIPED_STOPPED, "stopped by biped_stop"))
    }

    /// What this project's own controller would answer, and thinks. It must see all encoders of a run, once each.
    pub(crate) fn plan(&mut self) -> Result<(Torques, Telemetry), Failure> {
        if self.is_answered {
            return Err(Failure::misuse("nothing waits for an answer: call biped_wait, then biped_plan once"));
        }
        let fault = |error: ControllerError| Failure::new(BIPED_DEFECT, format!("no torques for this robot: {error}"));
        let Stamp { run, seq, .. } = self.sensors.stamp;
        let walker = match self.walker.take().filter(|(of, ..)| *of == run) {
            Some(walker) => self.walker.insert(walker),
            None => self.walker.insert((run, 0, Box::new(Planner::new(&self.scene).map_err(fault)?))),
        };
        if std::mem::replace(&mut walker.1, seq) == seq {
            return Err(Failure::misuse("biped_plan has seen these encoders: call it once for each biped_wait"));
        }
        let torques = walker.2.tick(&self.sensors.encoders).map_err(fault)?;
        Ok((torques, walker.2.telemetry()))
    }

    fn no_plant(&self) -> Failure {
        Failure::new(BIPED_NO_PLANT, format!("no plant sent sensors within {:?}", self.patience))
    }

    /// What the joints report.
    pub(crate) fn encoders(&self) -> Result<Encoders, Failure> {
        match self.sensors.stamp.seq {
            0 => Err(Failure::misuse("there are no encoders yet: call biped_wait first")),
            _ => Ok(self.sensors.encoders),
        }
    }

    /// Answers what came last.
    pub(crate) fn answer(&mut self, torques: Torques, telemetry: Telemetry) -> Result<(), Failure> {
        if self.is_answered {
            return Err(Failure::misuse("nothing waits for an answer: call biped_wait, then biped_write once"));
        }
        if let Some(joint) = torques.torque.iter().position(|torque| !torque.is_finite()) {
            return Err(Failure::misuse(format!("torque[{joint}] is {}", torques.torque[joint])));
        }
        (self.answer.torques, self.answer.telemetry) = (torques, telemetry);
        self.send()?;
        self.is_answered = true;
        Ok(())
    }

    fn send(&mut self) -> Result<(), PortError> {
        let (asked, seq) = (self.sensors.stamp, self.answer.stamp.seq + 1);
        self.answer.stamp = Stamp { seq, ack: asked.seq, sim_ns: asked.sim_ns, mono_ns: now_ns(), ..self.answer.stamp };
        self.port.send(self.answer)
    }

    /// Where it is.
    pub(crate) fn status(&self) -> Status {
        let Stamp { run, seq, sim_ns, .. } = self.sensors.stamp;
        Status { run, seq, time: sim_ns as f64 * 1e-9, ..self.robot }
    }
}

/// What a controller needs to know of the robot.
fn robot(scene: &Scene) -> Status {
    let mut start = [0.0; 8];
    start.iter_mut().zip(&scene.initial.joints).for_each(|(start, &angle)| *start = angle);
    let count = TAU / 2_f64.powi(scene.plant.encoder_bits as i32);
    Status { rate: scene.rate, count, torque_limit: scene.plant.torque_limit, start, ..Status::default() }
}
