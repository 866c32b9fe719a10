//! Plant and controller in one process, by plain calls: the bits of two.

use super::watch::{Watch, goes_on};
use crate::exit::{Exit, Failure, unless};
use messages::scene::Scene;
use messages::wire::{Command, Sensors, Stamp, Stamped, Truth};
use plant::Simulation;
use plant::process::Next;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

/// Records that are handed over at once, and such batches under way.
const BATCH: usize = 512;
const BATCHES: usize = 2;

/// One process, with the recorder in a thread of its own, which gets the truth in batches.
pub fn run(scene: &Scene, watch: &mut Watch, stop: &AtomicBool) -> Result<(), Failure> {
    let (full, heard) = mpsc::sync_channel::<Vec<Truth>>(BATCHES);
    let (empty, recycled) = mpsc::channel();
    let listen = move || {
        for mut batch in heard {
            for truth in &batch {
                watch.take(truth);
                goes_on(&watch.recorder, stop)?;
            }
            batch.clear();
            watch.show();
            let _ = empty.send(batch); // at the end nobody needs it
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let listener = scope.spawn(listen);
        let mut batch = Vec::with_capacity(BATCH);
        let outcome = in_process(scene, |truth| {
            unless(stop)?;
            batch.push(*truth);
            if batch.len() < BATCH {
                return Ok(());
            }
            let next = recycled.try_recv().unwrap_or_else(|_| Vec::with_capacity(BATCH));
            full.send(std::mem::replace(&mut batch, next)).map_err(|_| Failure::new(Exit::Fault, "nobody records"))
        });
        let _ = full.send(batch);
        drop(full);
        // Who records says why he stopped.
        listener.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)).and(outcome)
    })
}

/// One process: the plant's loop with a controller at the other end of a function call. `hear` gets the truth of each
/// control period and may end the run by an error.
///
/// # Errors
/// Whatever plant, controller or `hear` fails with.
pub fn in_process(scene: &Scene, mut hear: impl FnMut(&Truth) -> Result<(), Failure>) -> Result<(), Failure> {
    disturbed_in_process(scene, |truth, _| hear(truth))
}

/// The same; `hear` may also push the robot.
///
/// # Errors
/// As [`in_process`].
pub fn disturbed_in_process(
    scene: &Scene,
    mut hear: impl FnMut(&Truth, &mut Simulation) -> Result<(), Failure>,
) -> Result<(), Failure> {
    use controller::process::ProcessError;
    let controller = scene.controller.as_ref().map(|_| controller::Controller::new(scene)).transpose();
    let mut controller = controller.map_err(ProcessError::from)?;
    let mut simulation = Simulation::new(scene, 1, 1)?;
    plant::process::drive(&mut simulation, |simulation, sensors: &Sensors, shell| {
        hear(&shell.truth(simulation, sensors), simulation)?;
        if let Some(controller) = controller.as_mut().filter(|_| sensors.last == 0) {
            let torques = controller.tick(&sensors.encoders).map_err(ProcessError::from)?;
            let stamp = Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
            simulation.receive(&Command { stamp, torques, telemetry: controller.telemetry() }.sealed());
        }
        Ok(Next::Period { late_ns: 0 })
    })
}
