//! A run: the plant, the command pipeline before its drives, and the count of its control periods.

use crate::error::PlantError;
use crate::intake::Intake;
use crate::step::Plant;
use crate::watchdog::Mode;
use messages::scene::Scene;
use messages::wire::{Command, Encoders, Sensors, Stamp, Truth};

/// A run of a scene. It reads no clock: the process around it sets the times in messages.
pub struct Simulation {
    scene: Scene,
    plant: Plant,
    intake: Intake,
    encoders: Encoders,
    /// Control periods of the scene.
    periods: u64,
    /// Run, epoch, sequence number and simulated time of the present sensor message.
    stamp: Stamp,
}

impl Simulation {
    /// Run number `run` of a scene, at time zero, in the process with this `epoch`.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn new(scene: &Scene, run: u64, epoch: u64) -> Result<Simulation, PlantError> {
        let plant = Plant::new(scene)?;
        Ok(Simulation {
            intake: Intake::new(scene, run),
            encoders: plant.encoders(),
            periods: (scene.duration * scene.rate).round() as u64,
            stamp: Stamp { run, epoch, seq: 1, ..Stamp::default() },
            scene: scene.clone(),
            plant,
        })
    }

    /// Restarts from the beginning as run number `run`, with a new seed if one is given.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn reset(&mut self, run: u64, seed: Option<u64>) -> Result<(), PlantError> {
        let mut scene = self.scene.clone();
        if let Some(seed) = seed {
            (scene.plant.seed, scene.link.seed) = (seed, seed);
        }
        *self = Simulation::new(&scene, run, self.stamp.epoch)?;
        Ok(())
    }

    /// The present sensor message. Its sequence number is 1 at time zero. After the last period it asks for no answer.
    pub fn sensors(&self) -> Sensors {
        Sensors { stamp: self.stamp, encoders: self.encoders, last: u64::from(self.stamp.seq > self.periods) }
    }

    /// Ground truth at the same instant.
    pub fn truth(&self) -> Truth {
        let mut truth = self.plant.truth();
        Command { stamp: truth.command, torques: truth.asked, telemetry: truth.telemetry } = self.intake.newest();
        truth.stamp = self.stamp;
        truth.state = self.intake.mode() as u32;
        truth.age = self.intake.age() as u32;
        truth.tally = *self.intake.tally();
        truth.encoders = self.encoders;
        truth
    }

    /// Receives a sealed command.
    pub fn receive(&mut self, command: &Command) {
        self.intake.hear(command, self.stamp.seq);
    }

    /// One control period.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn advance(&mut self) -> Result<(), PlantError> {
        let torques = self.intake.torques(&self.sensors());
        self.encoders = self.plant.advance(&torques)?;
        self.stamp = Stamp { seq: self.stamp.seq + 1, sim_ns: self.plant.time_ns(), ..self.stamp };
        Ok(())
    }

    /// As [`Plant::prepare`].
    pub fn prepare(&mut self) {
        self.plant.prepare();
    }

    /// As [`Plant::push`].
    pub fn push(&mut self, body: usize, impulse: [f64; 3], duration: f64) -> bool {
        self.plant.push(body, impulse, duration)
    }

    /// Mode that determined the torques of the last period.
    pub fn mode(&self) -> Mode {
        self.intake.mode()
    }

    /// The command pipeline before the drives.
    pub fn intake(&mut self) -> &mut Intake {
        &mut self.intake
    }
}
