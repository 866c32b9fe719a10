//! Plant and controller in one process, by function calls. The results are bit for bit those of two processes.

use super::monitor::{RunMonitor, check_run};
use controller::Controller;
use controller::process::ProcessError;
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
    InProcess::new(scene)?.finish(|truth, _| observe(truth))
}

/// A run of a scene in this process, under way.
pub struct InProcess {
    simulation: Simulation,
    controller: Option<Controller>,
}

impl InProcess {
    /// The run at time zero.
    ///
    /// # Errors
    /// If the scene cannot be simulated or controlled.
    pub fn new(scene: &Scene) -> Result<InProcess, Failure> {
        let controller = scene.controller.as_ref().map(|_| Controller::new(scene)).transpose();
        let controller = controller.map_err(ProcessError::from)?;
        Ok(InProcess { simulation: Simulation::new(scene, 1, 1)?, controller })
    }

    /// The truth at this instant.
    pub fn truth(&self) -> Truth {
        self.simulation.truth()
    }

    /// A run of the same scene that continues from the present state of this one.
    ///
    /// # Errors
    /// As [`InProcess::new`].
    pub fn branch(&self, scene: &Scene) -> Result<InProcess, Failure> {
        let mut simulation = Simulation::new(scene, 1, 1)?;
        simulation.restore(&self.simulation.snapshot());
        Ok(InProcess { simulation, controller: self.controller.clone() })
    }

    /// Continues the run to its end. In each control period `observe` gets the truth and the simulation, for example to push the robot. It can
    /// interrupt the run by an error, before the controller gets the sensors of this period.
    ///
    /// # Errors
    /// The first failure of plant, controller or `observe`.
    pub fn finish(
        &mut self,
        mut observe: impl FnMut(&Truth, &mut Simulation) -> Result<(), Failure>,
    ) -> Result<(), Failure> {
        let InProcess { simulation, controller } = self;
        let _under_way = UnderWay::begin(RESULTS_LOST);
        plant::process::drive(simulation, |simulation, sensors: &Sensors, shell| {
            observe(&shell.truth(simulation, sensors), simulation)?;
            if let Some(controller) = controller.as_mut().filter(|_| sensors.last == 0) {
                let torques = controller.tick(&sensors.encoders).map_err(ProcessError::from)?;
                let stamp = Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
                simulation.receive(&Command { stamp, torques, telemetry: controller.telemetry() }.sealed());
            }
            Ok(ExchangeOutcome::Advance { late_ns: 0 })
        })
    }
}
