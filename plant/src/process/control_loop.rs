//! The loop over the control periods of a run, for a controller in this process or in another one.

use crate::{PlantError, Simulation};
use messages::clock::now_ns;
use messages::wire::{Sensors, Truth};

/// Next action after an exchange of messages.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ExchangeOutcome {
    /// Simulate one control period.
    Advance {
        /// Delay of the period's start after its deadline in real time [ns].
        late_ns: u64,
    },
    /// Send sensors again, because the simulation has been reset.
    Restart,
}

/// Real time that the last control period took, by part [ns].
#[derive(Clone, Copy, Debug, Default)]
pub struct PeriodTiming {
    plant_ns: u64,
    wait_ns: u64,
    late_ns: u64,
    reply_ns: u64,
}

impl PeriodTiming {
    /// The truth that belongs to the sensors that have just been sent.
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

/// Runs the simulation to its end. In each control period `exchange` receives the sensors and passes commands to the simulation.
///
/// # Errors
/// An error of the plant or of `exchange`.
pub fn drive<E: From<PlantError>>(
    simulation: &mut Simulation,
    mut exchange: impl FnMut(&mut Simulation, &Sensors, &PeriodTiming) -> Result<ExchangeOutcome, E>,
) -> Result<(), E> {
    let (mut timing, mut now) = (PeriodTiming::default(), now_ns());
    loop {
        let mut sensors = simulation.sensors();
        sensors.stamp.mono_ns = now;
        let outcome = exchange(simulation, &sensors, &timing)?;
        let answered = now_ns();
        match outcome {
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
