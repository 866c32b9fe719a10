//! The peer of a plant: its controller and a recorder.

use super::program::{ProgramSetup, ProgramUnderTest};
use super::report::Finding;
use super::stamps::{Expected, Stamps};
use controller::Controller;
use messages::clock::{now_ns, random};
use messages::peer_environment::PeerEnvironment;
use messages::port::{ControllerPort, PortError, RecorderPort};
use messages::wire::{Command, Sensors, Stamp, Stamped, Truth};
use std::time::{Duration, Instant};

/// Time after which a message counts as absent.
const SILENCE: Duration = Duration::from_millis(100);

/// The peer's side of a session, with the messages of the plant.
pub struct Driver {
    port: ControllerPort,
    recorder: RecorderPort,
    pub controller: Controller,
    rate: f64,
    patience: Duration,
    pub stamps: Stamps,
    /// The latest sensors; number 0 before the first ones.
    pub sensors: Sensors,
    pub truths: Vec<Truth>,
    /// Stamp of the last command.
    pub stamp: Stamp,
    since_ns: u64,
}

impl Driver {
    pub fn new(host: &ProgramSetup, environment: &PeerEnvironment) -> Result<Driver, String> {
        let text = |error: PortError| error.to_string();
        Ok(Driver {
            recorder: RecorderPort::open(&environment.session, &environment.contract).map_err(text)?,
            port: ControllerPort::open(&environment.session, &environment.contract).map_err(text)?,
            controller: Controller::new(&host.scene).map_err(|error| error.to_string())?,
            rate: host.scene.rate,
            patience: host.patience,
            stamps: Stamps::default(),
            sensors: Sensors::default(),
            truths: vec![],
            stamp: Stamp { epoch: random(), ..Stamp::default() },
            since_ns: now_ns(),
        })
    }

    /// Waits a short time for new sensors; repeated ones do not count.
    pub fn receive_sensors(&mut self) -> Result<bool, String> {
        while let Some(truth) = self.recorder.read().map_err(|error| error.to_string())? {
            self.truths.push(*truth);
        }
        let Some(sensors) = self.port.wait().map_err(|error| error.to_string())? else { return Ok(false) };
        let (now, before) = (sensors.stamp, self.sensors.stamp);
        if (now.run, now.seq) == (before.run, before.seq) && sensors.is_sound() {
            return Ok(false);
        }
        let sim_ns = (now.seq.saturating_sub(1) as f64 * 1e9 / self.rate).round() as u64;
        self.stamps.check(&sensors, Expected { run: 0, ack: 0, sim_ns, sent_ns: [self.since_ns, now_ns()] });
        if now.run != self.stamp.run {
            self.stamp = Stamp { run: now.run, seq: 0, ..self.stamp };
        }
        self.sensors = sensors;
        Ok(true)
    }

    /// The next sensors, or why there are none.
    pub fn next(&mut self, program: &mut ProgramUnderTest) -> Result<Sensors, String> {
        let start = Instant::now();
        while !self.receive_sensors()? {
            let missing = format_args!("no sensors after number {}", self.sensors.stamp.seq);
            program.may_answer(missing, start, self.patience)?;
        }
        Ok(self.sensors)
    }

    /// Checks that no sensors arrive.
    pub fn silence(&mut self) -> Finding {
        let start = Instant::now();
        while start.elapsed() < SILENCE {
            if self.receive_sensors()? {
                return Err(format!("sensors {} came", self.sensors.stamp.seq));
            }
        }
        Ok(String::new())
    }

    /// The answer to the latest sensors, not yet sent.
    pub fn answer(&mut self) -> Result<Command, String> {
        let torques = self.controller.tick(&self.sensors.encoders).map_err(|error| error.to_string())?;
        let Stamp { seq, sim_ns, .. } = self.sensors.stamp;
        self.stamp = Stamp { seq: self.stamp.seq + 1, ack: seq, sim_ns, mono_ns: now_ns(), ..self.stamp };
        Ok(Command { stamp: self.stamp, torques, ..Command::default() }.sealed())
    }

    pub fn send_raw_command(&mut self, command: Command) -> Result<(), String> {
        self.since_ns = now_ns();
        self.port.send_raw(command).map_err(|error| error.to_string())
    }

    /// Runs control periods in lockstep until these sensors or the last ones.
    pub fn drive(&mut self, program: &mut ProgramUnderTest, until: u64) -> Result<(), String> {
        while self.sensors.stamp.seq < until && self.sensors.last == 0 {
            let command = self.answer()?;
            self.send_raw_command(command)?;
            self.next(program)?;
        }
        Ok(())
    }
}
