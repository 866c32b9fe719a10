//! The whole walk over the link in lockstep: the cost of a control period if the plant waits for each answer.

use super::bench::Bench;
use super::initiator::Initiator;
use super::results::Results;
use super::second_process::Order;
use super::spread::Spread;
use messages::clock::now_ns;
use messages::load::load;
use messages::port::{Contract, Pace, Waiting};
use messages::scene::Scene;
use plant::Simulation;
use plant::process::ExchangeOutcome;
use shared::exit::Failure;
use shared::list;

/// The walk with this duration.
///
/// # Errors
/// None: the scene is built in.
pub fn scene(seconds: f64) -> Result<Scene, Failure> {
    Ok(load("walk", &[format!("duration={seconds}")], list::SCENES)?)
}

/// Each wait mode with its section.
pub const WAYS: [(Waiting, &str); 3] = [
    (Waiting::Spin, "walk in lockstep, spin"),
    (Waiting::Hybrid, "walk in lockstep, hybrid"),
    (Waiting::Event, "walk in lockstep, event"),
];

/// How a walk ends.
enum End {
    Time,
    Failed(Failure),
}

impl<E: Into<Failure>> From<E> for End {
    fn from(error: E) -> End {
        End::Failed(error.into())
    }
}

/// The walk with the plant here and the controller in the other process, for each wait mode in turn.
///
/// # Errors
/// A link that breaks, or Ctrl-C.
pub fn measure(bench: &mut Bench, results: &mut Results) -> Result<(), Failure> {
    bench.begin_group("the walk in lockstep");
    let seconds = bench.plan.walk_s;
    let scene = scene(seconds)?;
    for (waiting, section) in WAYS {
        bench.step(section)?;
        let session = bench.session()?;
        let mut initiator = Initiator::open(&session, &Contract::of(&scene, Pace::Lockstep), waiting, bench.stop)?;
        bench.peer.order(&Order::Walk { session: session.name().into(), waiting, seconds })?;
        let (mut compute, mut period) = (Spread::new()?, Spread::new()?);
        let mut simulation = Simulation::new(&scene, 1, 1)?;
        let limit = now_ns() + bench.plan.walk_ns;
        let walked = plant::process::drive(&mut simulation, |simulation, sensors, _| {
            let begun = initiator.received_ns;
            if sensors.last != 0 || begun > limit {
                return Err(End::Time);
            }
            let command = match begun {
                0 => initiator.ask(sensors)?, // the other side may still be starting
                _ => initiator.exchange(*sensors)?,
            };
            simulation.receive(&command);
            if begun > 0 {
                compute.add(sensors.stamp.mono_ns - begun);
                period.add(initiator.received_ns - begun);
            }
            Ok(ExchangeOutcome::Advance { late_ns: 0 })
        });
        if let Err(End::Failed(failure)) = walked {
            return Err(failure);
        }
        initiator.end(results, section)?;
        results.put(section, "plant computes", &compute);
        results.put(section, "whole period", &period);
    }
    Ok(())
}

/// Number of measurements.
pub fn count() -> usize {
    WAYS.len()
}
