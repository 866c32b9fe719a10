//! A run of a scene: the plant, its command pipeline, and the number of the control period.

use crate::command_pipeline::CommandPipeline;
use crate::error::PlantError;
use crate::step::{Plant, PlantSnapshot};
use messages::scene::Scene;
use messages::wire::{Command, Encoders, PlantState, Sensors, Stamp, Truth};
use serde::{Deserialize, Serialize};

/// A run of a scene. It uses no clock: the process fills in the times of its messages.
pub struct Simulation {
    scene: Scene,
    plant: Plant,
    commands: CommandPipeline,
    encoders: Encoders,
    /// Number of control periods of the scene.
    periods: u64,
    /// Run, epoch, sequence number and simulated time of the present sensor message.
    stamp: Stamp,
}

/// The state of a run, to continue from it later.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct SimulationSnapshot {
    plant: PlantSnapshot,
    commands: CommandPipeline,
    encoders: Encoders,
    stamp: Stamp,
    /// Seeds of the plant and of the link.
    seeds: [u64; 2],
}

impl Simulation {
    /// The run with the number `run` at time zero, in the process with the number `epoch`.
    ///
    /// # Errors
    /// As [`Plant::new`].
    pub fn new(scene: &Scene, run: u64, epoch: u64) -> Result<Simulation, PlantError> {
        let plant = Plant::new(scene)?;
        Ok(Simulation {
            commands: CommandPipeline::new(scene, run),
            encoders: plant.encoders(),
            periods: scene.periods(),
            stamp: Stamp { run, epoch, seq: 1, ..Stamp::default() },
            scene: scene.clone(),
            plant,
        })
    }

    /// Starts again from time zero as the run with the number `run`, with another seed if one is given.
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

    /// The sensors at this instant. At time zero they have the number 1. The last ones of a run need no answer.
    pub fn sensors(&self) -> Sensors {
        Sensors { stamp: self.stamp, encoders: self.encoders, last: u64::from(self.stamp.seq > self.periods) }
    }

    /// The truth at this instant.
    pub fn truth(&self) -> Truth {
        let mut truth = self.plant.truth();
        Command { stamp: truth.command, torques: truth.asked, telemetry: truth.telemetry } = self.commands.newest();
        truth.stamp = self.stamp;
        truth.state = self.commands.state() as u32;
        truth.age = self.commands.age() as u32;
        truth.tally = *self.commands.tally();
        truth.encoders = self.encoders;
        truth
    }

    /// Passes a sealed command to the pipeline.
    pub fn receive(&mut self, command: &Command) {
        self.commands.receive(command, self.stamp.seq);
    }

    /// One control period.
    ///
    /// # Errors
    /// As [`Plant::advance`].
    pub fn advance(&mut self) -> Result<(), PlantError> {
        let torques = self.commands.torques(&self.sensors());
        self.encoders = self.plant.advance(&torques)?;
        self.stamp = Stamp { seq: self.stamp.seq + 1, sim_ns: self.plant.time_ns(), ..self.stamp };
        Ok(())
    }

    /// The present state.
    pub fn snapshot(&self) -> SimulationSnapshot {
        SimulationSnapshot {
            plant: self.plant.snapshot(),
            commands: self.commands.clone(),
            encoders: self.encoders,
            stamp: self.stamp,
            seeds: [self.scene.plant.seed, self.scene.link.seed],
        }
    }

    /// As [`Plant::restore`], with the commands that are under way.
    pub fn restore(&mut self, snapshot: &SimulationSnapshot) {
        self.plant.restore(&snapshot.plant);
        self.commands.clone_from(&snapshot.commands);
        (self.encoders, self.stamp) = (snapshot.encoders, snapshot.stamp);
        [self.scene.plant.seed, self.scene.link.seed] = snapshot.seeds;
    }

    /// The plant.
    pub fn plant(&self) -> &Plant {
        &self.plant
    }

    /// As [`Plant::prepare`].
    pub fn prepare(&mut self) {
        self.plant.prepare();
    }

    /// As [`Plant::push`].
    pub fn push(&mut self, body: usize, impulse: [f64; 3], duration: f64) -> bool {
        self.plant.push(body, impulse, duration)
    }

    /// State of the plant in the last control period.
    pub fn state(&self) -> PlantState {
        self.commands.state()
    }

    /// The command pipeline.
    pub fn commands(&mut self) -> &mut CommandPipeline {
        &mut self.commands
    }
}
