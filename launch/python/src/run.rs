//! The run of a plant: control periods as in `biped run --in-process`, with torques from any source.

use crate::arrays::converted;
use crate::error::{ControllerError, EndedError, InputError, SimulationError, without_panic};
use crate::scene::Scene;
use messages::wire::{Command, JOINTS, PlantState, REFUSALS, Stamp, Stamped, Telemetry, Torques, Truth};
use numpy::{PyReadonlyArray2, PyUntypedArrayMethods};
use plant::kinematics::{Pose, Totals, pose, totals};
use plant::{PlantError, Simulation, SimulationSnapshot};
use pyo3::prelude::*;
use records::analysis::{DerivedState, InitialPosture, KinematicTree};
use std::time::Instant;

/// A run, and the data for judging whether the robot has fallen.
pub struct Run {
    pub simulation: Simulation,
    number: u64,
    /// The error that ended the run.
    failure: Option<String>,
    tree: KinematicTree,
    initial: InitialPosture,
}

/// Why a control period was not simulated.
pub enum Stopped {
    Ended(f64),
    Refused(&'static str),
    Failed(String),
}

impl From<PlantError> for Stopped {
    fn from(error: PlantError) -> Stopped {
        Stopped::Failed(error.to_string())
    }
}

impl From<Stopped> for PyErr {
    fn from(stopped: Stopped) -> PyErr {
        match stopped {
            Stopped::Ended(time) => {
                EndedError::new_err(format!("the run ended at t = {time} s: call reset(), or set a longer duration"))
            }
            Stopped::Refused(reason) => InputError::new_err(format!("the plant refuses these torques: {reason}")),
            Stopped::Failed(sentence) => SimulationError::new_err(sentence),
        }
    }
}

impl Run {
    /// The run of a scene at time zero.
    pub fn new(scene: &messages::scene::Scene) -> Result<Run, PlantError> {
        let simulation = Simulation::new(scene, 1, 1)?;
        let tree = KinematicTree::new(scene);
        let initial = InitialPosture::new(&tree, &derived(&tree, &simulation.truth()));
        Ok(Run { simulation, number: 1, failure: None, tree, initial })
    }

    /// Starts again from time zero.
    pub fn reset(&mut self, seed: Option<u64>) -> Result<(), PlantError> {
        self.number += 1;
        self.failure = None;
        self.simulation.reset(self.number, seed)
    }

    /// Returns to a snapshot.
    pub fn restore(&mut self, snapshot: &SimulationSnapshot) -> Result<(), Stopped> {
        let outcome = without_panic(Stopped::Failed, || {
            self.simulation.restore(snapshot);
            Ok(())
        });
        self.keep_failure(outcome)
    }

    /// Remembers whether the run has failed.
    fn keep_failure(&mut self, outcome: Result<(), Stopped>) -> Result<(), Stopped> {
        self.failure = match &outcome {
            Err(Stopped::Failed(failure)) => Some(failure.clone()),
            _ => None,
        };
        outcome
    }

    /// Simulates control periods with these torques, or without a command. Stops at the end of the run.
    pub fn advance(&mut self, torques: Option<[f64; JOINTS]>, periods: u64) -> Result<(), Stopped> {
        if let Some(failure) = &self.failure {
            return Err(Stopped::Failed(format!("the run has failed: {failure}; call reset() or restore()")));
        }
        if self.ended() {
            return Err(Stopped::Ended(self.time()));
        }
        let outcome = without_panic(Stopped::Failed, || self.periods(torques, periods));
        self.keep_failure(outcome)
    }

    fn periods(&mut self, torques: Option<[f64; JOINTS]>, periods: u64) -> Result<(), Stopped> {
        for _ in 0..periods {
            if self.ended() {
                break;
            }
            if let Some(torque) = torques {
                self.command(Torques { torque }, Telemetry::default()).map_err(Stopped::Refused)?;
            }
            self.simulation.advance()?;
        }
        Ok(())
    }

    /// Sends the plant the command that answers its present sensors. Returns why it refuses the command, if it does so at once.
    fn command(&mut self, torques: Torques, telemetry: Telemetry) -> Result<(), &'static str> {
        let asked = self.simulation.sensors().stamp;
        let before = self.simulation.commands().tally().refused;
        let stamp = Stamp { ack: asked.seq, ..asked };
        self.simulation.receive(&Command { stamp, torques, telemetry }.sealed());
        let after = self.simulation.commands().tally().refused;
        let refused = (0..REFUSALS.len()).find(|reason| after[*reason] != before[*reason]);
        refused.map_or(Ok(()), |reason| Err(REFUSALS[reason]))
    }

    pub fn ended(&self) -> bool {
        self.simulation.sensors().last != 0
    }

    /// Simulated time [s].
    pub fn time(&self) -> f64 {
        self.simulation.sensors().stamp.time()
    }

    /// Whether the posture is that of a fallen robot, as `biped run` judges it.
    pub fn fallen(&self) -> bool {
        let truth = self.simulation.truth();
        self.tree.feet.is_some() && self.initial.has_fallen(&derived(&self.tree, &truth))
    }

    /// Mass, momentum and energy of the robot.
    pub fn totals(&self) -> Totals {
        let plant = self.simulation.plant();
        let (model, state) = (plant.model(), plant.state());
        let mut present = Pose::new(model);
        pose(model, state, &mut present);
        totals(model, state, &present)
    }

    /// State of the plant in the last control period.
    pub fn state(&self) -> PlantState {
        self.simulation.state()
    }
}

fn derived(tree: &KinematicTree, truth: &Truth) -> DerivedState {
    DerivedState::new(tree, truth, &tree.body_states(truth))
}

/// Runs a scene without Python, with the torques of the rows of an array, shape (periods, 8) [N·m], or those of its controller: (control
/// periods, time [s], hash of all states). It is the reference for the speed of a loop in Python.
#[pyfunction]
#[pyo3(signature = (scene, torques = None))]
pub fn rust_loop(
    py: Python<'_>,
    scene: &Scene,
    torques: Option<PyReadonlyArray2<'_, f64>>,
) -> PyResult<(u64, f64, u64)> {
    let unfit = |error: controller::ControllerError| ControllerError::new_err(error.to_string());
    let mut run = Run::new(&scene.scene).map_err(Stopped::from)?;
    let given =
        torques.map(|rows| converted::<f64>("torques", rows.as_any(), &[rows.shape()[0], JOINTS])).transpose()?;
    let controller = given.is_none().then(|| controller::Controller::new(&scene.scene)).transpose();
    let mut controller = controller.map_err(unfit)?;
    let mut given = given.as_ref().map(|given| given.as_chunks::<JOINTS>().0.iter());
    py.detach(|| {
        let (start, mut done) = (Instant::now(), 0);
        while !run.ended() {
            if let Some(controller) = &mut controller {
                let torques = controller.tick(&run.simulation.sensors().encoders).map_err(unfit)?;
                run.command(torques, controller.telemetry()).map_err(Stopped::Refused)?;
            } else if let Some(&torque) = given.as_mut().and_then(Iterator::next) {
                run.command(Torques { torque }, Telemetry::default()).map_err(Stopped::Refused)?;
            }
            run.simulation.advance().map_err(Stopped::from)?;
            done += 1;
        }
        Ok((done, start.elapsed().as_secs_f64(), run.simulation.truth().hash))
    })
}
