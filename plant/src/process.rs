//! The plant as a process.
//!
//! [`drive`] is the loop over the control periods. The caller exchanges the messages, with a controller in another process
//! ([`run`]) or in this one. The results are the same.

mod answer_wait;
mod connection;
mod control_loop;
mod error;
mod log;
mod request_handler;

pub use answer_wait::{AnswerWait, Waited};
pub use control_loop::{ExchangeOutcome, PeriodTiming, drive};
pub use error::{Options, PlantProcessError};
pub use request_handler::{MAX_PUSH_DURATION, MAX_PUSH_IMPULSE, is_push_accepted};

use crate::Simulation;
use connection::ControllerConnection;
use messages::clock::{now_ns, random};
use messages::port::PlantPort;
use messages::scene::Scene;
use messages::wire::{PlantState, Sensors, Stamp, Tally, Truth};
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// A plant that fails at its start waits for this time, so that a controller can find it and read the goodbye.
const GOODBYE_TIME: Duration = Duration::from_millis(300);

/// Runs a scene with the controller at the other end of `port`. A scene without a controller runs alone, with zero torques.
///
/// The plant always sends a goodbye to the controller, also when it ends early. Returns the truth at the end of the scene.
///
/// # Errors
/// See [`PlantProcessError`]; the counters are complete in any case.
pub fn run(
    scene: &Scene,
    port: PlantPort,
    options: Options,
    stop: &AtomicBool,
) -> (Tally, Result<Truth, PlantProcessError>) {
    let mut simulation = match Simulation::new(scene, random(), random()) {
        Ok(simulation) => simulation,
        Err(error) => {
            // A controller that waits for this plant can stop waiting.
            let stamp = Stamp { run: random(), epoch: random(), seq: 1, mono_ns: now_ns(), ..Stamp::default() };
            let sent = port.send(Sensors { stamp, last: 1, ..Sensors::default() });
            std::thread::sleep(GOODBYE_TIME);
            return (Tally::default(), sent.map_err(Into::into).and(Err(error.into())));
        }
    };
    let mut connection = ControllerConnection::new(scene, port, options, stop);
    let result = drive(&mut simulation, |simulation, sensors, timing| connection.exchange(simulation, sensors, timing));
    let sent = match result {
        Ok(()) => {
            connection.port.finish();
            Ok(())
        }
        Err(_) => {
            let sent = connection.port.send(goodbye(&simulation));
            connection.port.wait_for_tunnel();
            sent
        }
    };
    simulation.commands().tally_mut().unrecorded = connection.port.unrecorded();
    let result = match (result, simulation.state()) {
        (Ok(()), PlantState::Fault) => Err(PlantProcessError::Silent(simulation.commands().age())),
        (result, _) => result,
    };
    let result = result.and(sent.map_err(PlantProcessError::from));
    (*simulation.commands().tally(), result.map(|()| simulation.truth()))
}

/// The last message to the controller.
fn goodbye(simulation: &Simulation) -> Sensors {
    let sensors = simulation.sensors();
    Sensors { stamp: Stamp { seq: sensors.stamp.seq + 1, ..sensors.stamp }, last: 1, ..sensors }
}
