//! View (ii): CPU time per step of 1 ms, for scenes with more and more contacts.

use super::cases::{self, Combination, LAW, METHOD};
use super::core::Core;
use super::csv::{Measurement, OURS, View};
use super::trial::{RunEnd, quantile, times, watch_until};
use super::watch::{ChartProgress, Job};
use messages::scene::{Law, Method, Scene};
use messages::wire::Torques;
use shared::exit::{Exit, Failure};
use std::sync::atomic::AtomicBool;

/// Timed scenes: name, title, and duration [s].
pub const LOADS: [(&str, &str, f64); 4] = [
    ("free", "flight", 1.0),
    ("slide", "a cube slides", 0.4),
    ("stand0", "a biped stands on 8 points", 1.0),
    ("walk", "a biped walks", 2.5),
];
/// The step [s].
pub const H: f64 = 1e-3;
/// Height of the trunk's centre below which the robot of Table 1 has fallen [m]. Standing and walking, it is at 0.52 m.
const FALLEN: f64 = 0.2;
/// Metric: median of the step times.
pub const MEDIAN: &str = "median";
/// Metric: 99th percentile of the step times.
pub const P99: &str = "p99";

/// Time per step of every law, and of every integrator under one law.
///
/// # Errors
/// Ctrl-C, or an invalid scene. A method has no row if it cannot simulate the scene or if the robot falls.
pub fn measure(quick: bool, progress: &ChartProgress) -> Result<Vec<Measurement>, Failure> {
    let mut rows = Vec::new();
    let _core = Core::hold();
    for (name, _, duration) in LOADS {
        let combinations = combinations(name, quick);
        progress.expect(combinations.len());
        for combination in combinations {
            progress.step(Job::Timing)?;
            let mut scene = cases::scene(name, combination, H, &[])?;
            let duration = if combination.share() < 1.0 { 0.1 * duration } else { duration };
            scene.duration = if quick { duration.min(0.4) } else { duration };
            let Some(mut times) = step_times(&scene, progress.stop)? else { continue };
            rows.extend([(MEDIAN, 0.5), (P99, 0.99)].map(|(metric, share)| {
                let seconds = quantile(&mut times, share);
                Measurement {
                    view: View::Steps,
                    scene: name.into(),
                    engine: OURS.into(),
                    method: combination.name(),
                    dt: H,
                    metric: metric.into(),
                    error: f64::NAN,
                    cost: seconds / H,
                    us_per_step: 1e6 * seconds,
                }
            }));
        }
    }
    Ok(rows)
}

/// Every integrator, then every law. Laws make no difference in flight. Methods that take milliseconds per step are not used for walking.
fn combinations(name: &str, quick: bool) -> Vec<Combination> {
    let methods = Method::ALL.iter().map(|&method| Combination { law: LAW, method });
    let laws =
        Law::ALL.iter().filter(|&&law| law != LAW && name != "free").map(|&law| Combination { law, method: METHOD });
    let combinations = methods.chain(laws).filter(|combination| combination.share() == 1.0 || name != "walk");
    if quick { combinations.skip(1).take(3).collect() } else { combinations.collect() }
}

/// Time of every step [s]. The torques are those of the scene's controller in an earlier run; its states must be reproduced.
fn step_times(scene: &Scene, stop: &AtomicBool) -> Result<Option<Vec<f64>>, Failure> {
    let Some(torques) = driven(scene) else { return Ok(None) };
    let RunEnd::Done(log) = watch_until(scene, &torques, stop) else { return Ok(None) };
    match times(scene, &torques, stop)? {
        (times, hash) if hash == log.hash => Ok(Some(times)),
        _ => Err(Failure::new(Exit::Fault, "the timed run differs from the watched one")),
    }
}

/// The torques of each control period; `None` if the controller or the plant fails.
fn driven(scene: &Scene) -> Option<Vec<Torques>> {
    if scene.controller.is_none() {
        return Some(Vec::new());
    }
    let mut controller = controller::Controller::new(scene).ok()?;
    let mut plant = plant::Plant::new(scene).ok()?;
    let mut encoders = plant.encoders();
    let mut all = Vec::with_capacity(scene.periods() as usize);
    for _ in 0..scene.periods() {
        let torques = controller.tick(&encoders).ok()?;
        encoders = plant.advance(&torques).ok()?;
        all.push(torques);
    }
    (plant.truth().base_position[2] > FALLEN).then_some(all)
}
