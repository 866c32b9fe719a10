//! Plant and controller in one process, by function calls. The results are bit for bit those of two processes.

use super::monitor::{RunMonitor, check_run};
use messages::scene::Scene;
use messages::wire::{Command, Sensors, Stamp, Stamped, Truth};
use plant::Simulation;
use plant::process::ExchangeOutcome;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::interrupt::{RESULTS_LOST, UnderWay};
use shared::thread;
use std::sync::atomic::AtomicBool;
use std::sync::mpsc;

/// Control periods in a batch for the recording thread. Handing over single ones would cost more than recording them.
const BATCH: usize = 512;
/// Batches that can wait for the recording thread before the simulation waits for it.
const QUEUED_BATCHES: usize = 2;

/// Runs a scene in this process. The monitor runs in a second thread, which gets the truth in batches.
pub fn run(scene: &Scene, monitor: &mut RunMonitor, stop: &AtomicBool) -> Result<(), Failure> {
    let (full, received) = mpsc::sync_channel::<Vec<Truth>>(QUEUED_BATCHES);
    let (empty, recycled) = mpsc::channel();
    let recorded = monitor.recording.is_some();
    let _under_way = recorded.then(|| UnderWay::begin("its recording is cut off and has no index"));
    let record = move || {
        for mut batch in received {
            for truth in &batch {
                monitor.record(truth);
                check_run(&monitor.recorder, stop)?;
            }
            batch.clear();
            monitor.show_progress();
            let _ = empty.send(batch); // fails at the end of the run, when the simulation needs no further batch
        }
        Ok(())
    };
    std::thread::scope(|scope| {
        let recording = thread::start_scoped(scope, record)?;
        let mut batch = Vec::with_capacity(BATCH);
        let outcome = in_process(scene, |truth| {
            check_interrupt(stop)?;
            batch.push(*truth);
            if batch.len() < BATCH {
                return Ok(());
            }
            let next = recycled.try_recv().unwrap_or_else(|_| Vec::with_capacity(BATCH));
            full.send(std::mem::replace(&mut batch, next))
                .map_err(|_| Failure::new(Exit::Fault, "the recording thread has ended"))
        });
        let _ = full.send(batch);
        drop(full);
        // If the recording thread stopped the run, its failure says why.
        recording.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic)).and(outcome)
    })
}

/// Runs a scene in this process, without a second thread. `observe` gets the truth of each control period and can end the run by an error.
///
/// # Errors
/// The first failure of plant, controller or `observe`.
pub fn in_process(scene: &Scene, mut observe: impl FnMut(&Truth) -> Result<(), Failure>) -> Result<(), Failure> {
    in_process_with(scene, |truth, _| observe(truth))
}

/// Like [`in_process`], but `observe` also gets the simulation, for example to push the robot.
///
/// # Errors
/// As [`in_process`].
pub fn in_process_with(
    scene: &Scene,
    mut observe: impl FnMut(&Truth, &mut Simulation) -> Result<(), Failure>,
) -> Result<(), Failure> {
    use controller::process::ProcessError;
    let controller = scene.controller.as_ref().map(|_| controller::Controller::new(scene)).transpose();
    let mut controller = controller.map_err(ProcessError::from)?;
    let mut simulation = Simulation::new(scene, 1, 1)?;
    let _under_way = UnderWay::begin(RESULTS_LOST);
    plant::process::drive(&mut simulation, |simulation, sensors: &Sensors, shell| {
        observe(&shell.truth(simulation, sensors), simulation)?;
        if let Some(controller) = controller.as_mut().filter(|_| sensors.last == 0) {
            let torques = controller.tick(&sensors.encoders).map_err(ProcessError::from)?;
            let stamp = Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
            simulation.receive(&Command { stamp, torques, telemetry: controller.telemetry() }.sealed());
        }
        Ok(ExchangeOutcome::Advance { late_ns: 0 })
    })
}
