//! The plant as a process. [`drive`] is the loop; what is exchanged in it, and how long that may take, is up to the
//! caller: a controller in another process ([`run`]) or in this one, with the same results.

use crate::connection::ControllerConnection;
use crate::watchdog::Mode;
use crate::{PlantError, Simulation};
use messages::clock::{now_ns, random};
use messages::port::{Pace, PlantPort, PortError};
use messages::scene::Scene;
use messages::wire::{Sensors, Stamp, Tally, Truth};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Why a plant process ended before its time.
#[derive(Debug, thiserror::Error)]
pub enum ProcessError {
    /// The connection cannot be made or broke.
    #[error(transparent)]
    Port(#[from] PortError),
    /// The simulation failed.
    #[error("plant: {0}")]
    Plant(#[from] PlantError),
    /// Nobody answered in lockstep, or nobody came; with what was met so far.
    #[error("no controller answered within {0:?}{1}")]
    NoController(Duration, String),
    /// The controller fell silent, and nobody re-armed the drives.
    #[error("the controller was silent for {0} control periods: the drives were switched off")]
    Silent(u64),
    /// Ctrl-C or TERM.
    #[error("interrupted")]
    Interrupted,
}

/// How a plant process runs.
#[derive(Clone, Copy, Debug)]
pub struct Options {
    /// Lockstep or real time.
    pub pace: Pace,
    /// In real time, simulated time per real time.
    pub speed: f64,
    /// How long to wait for a controller.
    pub patience: Duration,
}

/// Time in which a controller finds a plant that fails at once, and reads its goodbye.
const GOODBYE_TIME: Duration = Duration::from_millis(300);

/// What comes after an exchange.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeOutcome {
    /// A control period, which began this late [ns].
    Advance {
        /// Against its deadline in real time [ns].
        late_ns: u64,
    },
    /// Sensors again: the simulation has been reset.
    Restart,
}

/// Runs a scene against the controller at the other end of `port`; a scene without one runs alone, without torques.
///
/// The controller is told of the end, also of an early one.
///
/// # Errors
/// See [`ProcessError`]; the tally is complete in any case.
pub fn run(scene: &Scene, port: PlantPort, options: Options, stop: &AtomicBool) -> (Tally, Result<(), ProcessError>) {
    let mut simulation = match Simulation::new(scene, random(), random()) {
        Ok(simulation) => simulation,
        Err(error) => {
            // whoever waits for this plant need not wait on
            let stamp = Stamp { run: random(), epoch: random(), seq: 1, mono_ns: now_ns(), ..Stamp::default() };
            let told = port.send(Sensors { stamp, last: 1, ..Sensors::default() });
            std::thread::sleep(GOODBYE_TIME);
            return (Tally::default(), told.map_err(Into::into).and(Err(error.into())));
        }
    };
    let mut connection = ControllerConnection::new(scene, port, options, stop);
    let result = drive(&mut simulation, |simulation, sensors, timing| connection.exchange(simulation, sensors, timing));
    let told = match result {
        Ok(()) => {
            connection.port.finish();
            Ok(())
        }
        Err(_) => {
            let said = connection.port.send(goodbye(&simulation));
            connection.port.wait_for_tunnel();
            said
        }
    };
    simulation.commands().tally_mut().unrecorded = connection.port.unrecorded();
    let result = match (result, simulation.mode()) {
        (Ok(()), Mode::Fault) => Err(ProcessError::Silent(simulation.commands().age())),
        (result, _) => result,
    };
    (*simulation.commands().tally(), result.and(told.map_err(ProcessError::from)))
}

/// The last word to the controller.
fn goodbye(simulation: &Simulation) -> Sensors {
    let sensors = simulation.sensors();
    Sensors { stamp: Stamp { seq: sensors.stamp.seq + 1, ..sensors.stamp }, last: 1, ..sensors }
}

/// What the timing measured over the period before [ns].
#[derive(Clone, Copy, Debug, Default)]
pub struct PeriodTiming {
    plant_ns: u64,
    wait_ns: u64,
    late_ns: u64,
    reply_ns: u64,
}

impl PeriodTiming {
    /// The truth that goes with these sensors, which have just been sent.
    pub fn truth(&self, simulation: &Simulation, sensors: &Sensors) -> Truth {
        let mut truth = simulation.truth();
        truth.stamp = sensors.stamp;
        PeriodTiming {
            plant_ns: truth.plant_ns,
            wait_ns: truth.wait_ns,
            late_ns: truth.late_ns,
            reply_ns: truth.reply_ns,
        } = *self;
        truth
    }
}

/// The loop: at each control period, `exchange` gets the sensors, and lets the simulation hear what the controller says.
///
/// # Errors
/// Whatever the plant or `exchange` fails with.
pub fn drive<E: From<PlantError>>(
    simulation: &mut Simulation,
    mut exchange: impl FnMut(&mut Simulation, &Sensors, &PeriodTiming) -> Result<ExchangeOutcome, E>,
) -> Result<(), E> {
    let (mut timing, mut now) = (PeriodTiming::default(), now_ns());
    loop {
        let mut sensors = simulation.sensors();
        sensors.stamp.mono_ns = now;
        let next = exchange(simulation, &sensors, &timing)?;
        let answered = now_ns();
        match next {
            ExchangeOutcome::Restart => (timing, now) = (PeriodTiming::default(), answered),
            ExchangeOutcome::Advance { .. } if sensors.last != 0 => return Ok(()),
            ExchangeOutcome::Advance { late_ns } => {
                let wait_ns = answered - now;
                simulation.advance()?;
                now = now_ns();
                let reply_ns = simulation.commands().reply_ns(&sensors.stamp);
                timing = PeriodTiming { plant_ns: now - answered, wait_ns, late_ns, reply_ns };
            }
        }
    }
}
