//! View (ii): CPU time per step of 1 ms, for scenes of growing contact.

use super::cases::{self, LAW, METHOD, Way};
use super::csv::{OURS, Row, View};
use super::trial::{Outcome, periods, time, watch};
use super::{Job, Watch};
use crate::exit::{Exit, Failure};
use messages::scene::{Law, Method, Scene};
use messages::wire::Torques;

/// A scene whose step is timed, what it shows, and for how long [s].
pub const LOADS: [(&str, &str, f64); 4] = [
    ("free", "flight", 1.0),
    ("slide", "a cube slides", 0.4),
    ("stand0", "a biped stands on 8 points", 1.0),
    ("walk", "a biped walks", 4.0),
];
/// The step [s].
const H: f64 = 1e-3;

/// The time per step of every law, and of every integrator under one law.
///
/// # Errors
/// Ctrl-C, or a scene that is refused. A way that cannot do a scene, or in which the robot falls, has no row.
pub fn rows(quick: bool, progress: &Watch) -> Result<Vec<Row>, Failure> {
    let mut rows = Vec::new();
    for (name, _, duration) in LOADS {
        let ways = ways(name, quick);
        progress.expect(ways.len());
        for way in ways {
            progress.step(Job::Timing)?;
            let mut scene = cases::scene(name, way, H, &[])?;
            let duration = if way.share() < 1.0 { 0.1 * duration } else { duration };
            scene.duration = if quick { duration.min(0.4) } else { duration };
            let Some(seconds) = measure(&scene)? else { continue };
            rows.push(Row {
                view: View::Steps,
                scene: name.into(),
                engine: OURS.into(),
                method: way.name(),
                dt: H,
                metric: String::new(),
                error: f64::NAN,
                cost: seconds / scene.duration,
                us_per_step: 1e6 * seconds / periods(&scene) as f64,
            });
        }
    }
    Ok(rows)
}

/// Flight knows no law; the walk is tuned for its own integrator.
fn ways(name: &str, quick: bool) -> Vec<Way> {
    let laws = Law::ALL.iter().filter(|_| name != "free").map(|&law| Way { law, method: METHOD });
    let methods = Method::ALL.iter().filter(|&&method| method != METHOD && name != "walk");
    let own = Way { law: LAW, method: Method::SemiImplicitEuler };
    let methods = methods.map(|&method| Way { law: LAW, method });
    let mut ways: Vec<_> =
        [Way { law: LAW, method: METHOD }].into_iter().chain(methods).chain(laws).chain([own]).collect();
    let mut seen = Vec::new();
    ways.retain(|way| {
        let new = !seen.contains(way);
        seen.push(*way);
        // What takes milliseconds a step would walk for minutes.
        new && (way.share() == 1.0 || name != "walk")
    });
    if quick { ways.into_iter().take(3).collect() } else { ways }
}

/// CPU time of the scene [s]: torques are those that its controller gave in a run before, whose states must come again.
fn measure(scene: &Scene) -> Result<Option<f64>, Failure> {
    let Some(torques) = driven(scene) else { return Ok(None) };
    let Outcome::Done(log) = watch(scene, &torques) else { return Ok(None) };
    match time(scene, &torques)? {
        (seconds, hash) if hash == log.hash => Ok(Some(seconds)),
        _ => Err(Failure::new(Exit::Fault, "the timed run differs from the watched one")),
    }
}

/// The torques of each control period; none if the controller or the plant gives up.
fn driven(scene: &Scene) -> Option<Vec<Torques>> {
    if scene.controller.is_none() {
        return Some(Vec::new());
    }
    let mut controller = controller::Controller::new(scene).ok()?;
    let mut plant = plant::Plant::new(scene).ok()?;
    let mut encoders = plant.encoders();
    let mut all = Vec::with_capacity(periods(scene));
    for _ in 0..periods(scene) {
        let torques = controller.tick(&encoders).ok()?;
        encoders = plant.advance(&torques).ok()?;
        all.push(torques);
    }
    (plant.truth().base_position[2] > 0.2).then_some(all)
}
