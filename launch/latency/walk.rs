//! The whole walk over the link in lockstep: what a control period costs when the plant waits for each answer.

use super::bench::Bench;
use super::peer::Order;
use super::results::Results;
use super::spread::Spread;
use super::talk::Talk;
use crate::exit::Failure;
use crate::list;
use messages::clock::now_ns;
use messages::load::load;
use messages::port::{Contract, Pace, Waiting};
use messages::scene::Scene;
use plant::Simulation;
use plant::process::Next;

/// The walk, so long.
///
/// # Errors
/// Never: the scene comes with the program.
pub fn scene(seconds: f64) -> Result<Scene, Failure> {
    Ok(load("walk", &[format!("duration={seconds}")], list::SCENES)?)
}

/// Each way of waiting, and its section.
pub const WAYS: [(Waiting, &str); 3] = [
    (Waiting::Spin, "walk in lockstep, spin"),
    (Waiting::Hybrid, "walk in lockstep, hybrid"),
    (Waiting::Event, "walk in lockstep, event"),
];

/// Why a walk ends.
enum End {
    Time,
    Failed(Failure),
}

impl<E: Into<Failure>> From<E> for End {
    fn from(error: E) -> End {
        End::Failed(error.into())
    }
}

/// The walk, plant here and controller in the other process, each way of waiting in turn.
///
/// # Errors
/// A link that breaks, or Ctrl-C.
pub fn measure(bench: &mut Bench, results: &mut Results) -> Result<(), Failure> {
    bench.tell("the walk in lockstep");
    let seconds = bench.plan.walk_s;
    let scene = scene(seconds)?;
    for (waiting, section) in WAYS {
        bench.step(section)?;
        let session = bench.session()?;
        let mut talk = Talk::open(&session, &Contract::of(&scene, Pace::Lockstep), waiting, bench.stop)?;
        bench.peer.order(&Order::Walk { session: session.name().into(), waiting, seconds })?;
        let (mut compute, mut period) = (Spread::new()?, Spread::new()?);
        let mut simulation = Simulation::new(&scene, 1, 1)?;
        let limit = now_ns() + bench.plan.walk_ns;
        let walked = plant::process::drive(&mut simulation, |simulation, sensors, _| {
            let begun = talk.heard_ns;
            if sensors.last != 0 || begun > limit {
                return Err(End::Time);
            }
            let command = match begun {
                0 => talk.ask(sensors)?, // the other side may just be coming
                _ => talk.exchange(*sensors)?,
            };
            simulation.receive(&command);
            if begun > 0 {
                compute.add(sensors.stamp.mono_ns - begun);
                period.add(talk.heard_ns - begun);
            }
            Ok(Next::Period { late_ns: 0 })
        });
        if let Err(End::Failed(failure)) = walked {
            return Err(failure);
        }
        talk.end(results, section)?;
        results.put(section, "plant computes", &compute);
        results.put(section, "whole period", &period);
    }
    Ok(())
}

/// How many measurements that is.
pub fn count() -> usize {
    WAYS.len()
}
