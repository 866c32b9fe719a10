//! `biped study pushes`: greatest push without a fall, by phase and direction, compared with the limit of a pendulum on feet.
//!
//! The impulse grows in steps until the robot falls. Survival is not monotonic, so greater impulses without a fall do not count. Long walks
//! with random pushes follow; they reveal controllers that withstand only a single push.
//!
//! Impulses of another robot are scaled by M √(g L), as in [`SimilarityScale`], and printed as those of the paper's robot.

mod limit;
mod trial;

use super::args::{Direction, StudyArgs};
use super::tables::{publish, table};
use clap::ValueEnum;
use limit::Pendulum;
use messages::load::load;
use messages::robot::SimilarityScale;
use messages::scene::Scene;
use rayon::prelude::*;
use shared::args::settings_with_robot;
use shared::csv;
use shared::exit::Failure;
use shared::list::SCENES;
use shared::progress::BatchProgress;
use std::f64::consts::TAU;
use std::sync::atomic::AtomicBool;
use trial::{BEGIN, UndisturbedWalk};
pub use trial::{TimedPush, disturbed};

/// The gaits of the study.
const GAITS: [(&str, &str); 2] = [("walk", "walking"), ("stamp", "stepping in place")];
/// Time after the push for which the robot must not fall [s].
const AFTER: f64 = 6.0;
/// Step and limit of the impulse [N·s].
const GROWTH: f64 = 0.5;
const GREATEST: f64 = 12.0;
/// Long walks: number, duration [s], greatest impulses [N·s], interval of the pushes [s].
const WALKS: [(usize, f64, f64); 2] = [(10, 600.0, 3.0), (10, 120.0, 5.0)];
const EVERY: f64 = 5.0;

/// Runs everything on all cores, prints the tables, and writes them if `--out` is given.
///
/// # Errors
/// A bad setting, Ctrl-C, or a folder that cannot be written.
pub fn run(args: &StudyArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let asked = &args.pushes;
    let settings = settings_with_robot(&asked.robot, &asked.settings);
    let scenes: Vec<Scene> = GAITS.iter().map(|(name, _)| load(name, &settings, SCENES)).collect::<Result<_, _>>()?;
    let directions = if asked.directions.is_empty() { Direction::value_variants() } else { &asked.directions };
    let shares = asked.shares();
    let mut phases = Vec::new();
    for scene in &scenes {
        for &direction in directions {
            phases.extend(shares.iter().map(|&share| (scene, direction, share)));
        }
    }
    let mut walks = Vec::new();
    for (count, duration, most) in WALKS {
        let first = asked.seed.unwrap_or(1);
        walks.extend((0..count as u64).map(|k| (duration, most, first.wrapping_add(k))));
    }
    let counter = BatchProgress::new(args.quiet, phases.len() + walks.len(), 0, "phases and walks");
    let survived: Vec<f64> = phases
        .par_iter()
        .map(|&(scene, direction, share)| survived(scene, direction, share, stop).inspect(|_| counter.add_done(1)))
        .collect::<Result<_, _>>()?;
    let ends: Vec<(Option<f64>, f64)> = walks
        .par_iter()
        .map(|&(duration, most, seed)| {
            let scene = Scene { duration, ..scenes[0].clone() };
            long_walk(&scene, most * impulse_scale(&scene), seed, stop).inspect(|_| counter.add_done(1))
        })
        .collect::<Result<_, _>>()?;
    counter.finish();
    let mut singles = survived.chunks(shares.len());
    let mut rows = vec![headings(&["gait", "direction", "least", "mean", "limit, least", "limit, mean", "by phase"])];
    for (scene, (_, gait)) in scenes.iter().zip(GAITS) {
        let pendulum = Pendulum::of(scene, stop)?;
        for (&direction, survived) in directions.iter().zip(&mut singles) {
            let limit = |&share: &f64| pendulum.limit(direction, share) / impulse_scale(scene);
            let limits: Vec<f64> = shares.iter().map(limit).collect();
            rows.push(row(gait, direction, survived, &limits));
        }
    }
    let mut walked = vec![headings(&["walks", "pushed every 5 s by up to", "fell", "at s", "greatest yaw °"])];
    let mut ends = ends.as_slice();
    for (count, duration, most) in WALKS {
        let (these, others) = ends.split_at(count);
        ends = others;
        let falls: Vec<String> = these.iter().filter_map(|(fall, _)| fall.map(|time| format!("{time:.0}"))).collect();
        let yaw = these.iter().filter(|(fall, _)| fall.is_none()).map(|(_, yaw)| *yaw).fold(0.0, f64::max);
        let cells = [format!("{count} of {duration} s"), format!("{most} N·s"), falls.len().to_string()];
        walked.push([&cells[..], &[falls.join(" "), format!("{yaw:.0}")]].concat());
    }
    let text = format!("{}\n{}{}", table(&rows), table(&walked), note_on_scale(&scenes[0]));
    publish(args, &text, &[("", csv::text(&rows)), ("-walks", csv::text(&walked))])
}

/// Ratio of the robot's impulses to those of the paper's robot: M √(g L), at equal gravity [-].
fn impulse_scale(scene: &Scene) -> f64 {
    let scale = SimilarityScale::between(&Scene::default().bodies, &scene.bodies);
    scale.mass * scale.speed()
}

fn note_on_scale(scene: &Scene) -> String {
    match impulse_scale(scene) {
        1.0 => String::new(),
        scale => format!(
            "\nImpulses are those of the paper's robot, M √(g L) being equal: this robot was pushed {scale:.3} times as hard.\n"
        ),
    }
}

/// Impulse [N·s], divided by [`impulse_scale`], up to which the robot does not fall, for a push at `share` of a period after [`BEGIN`].
fn survived(scene: &Scene, direction: Direction, share: f64, stop: &AtomicBool) -> Result<f64, Failure> {
    let period = scene.controller.as_ref().map_or(0.0, |controller| controller.period);
    let time = BEGIN + share * period;
    let scene = Scene { duration: time + AFTER, ..scene.clone() };
    let (scale, mut survived) = (impulse_scale(&scene), 0.0);
    let Some(walk) = UndisturbedWalk::until(&scene, time, stop)? else { return Ok(survived) };
    while survived < GREATEST {
        let impulse = direction.unit().map(|part| part * (survived + GROWTH) * scale);
        if walk.pushed(impulse, stop)?.fall.is_some() {
            break;
        }
        survived += GROWTH;
    }
    Ok(survived)
}

/// Time of the fall [s] of a walk with random pushes up to `most` [N·s], and its greatest yaw [deg].
fn long_walk(scene: &Scene, most: f64, seed: u64, stop: &AtomicBool) -> Result<(Option<f64>, f64), Failure> {
    let mut random = fastrand::Rng::with_seed(seed);
    let count = ((scene.duration - BEGIN) / EVERY) as usize;
    let push = |k| {
        let (angle, size) = (TAU * random.f64(), most * random.f64());
        let time = BEGIN + EVERY * k as f64 + random.f64();
        TimedPush { time, impulse: [size * angle.cos(), size * angle.sin(), 0.0] }
    };
    let pushes: Vec<TimedPush> = (0..count).map(push).collect();
    let end = disturbed(scene, &pushes, stop)?;
    Ok((end.fall, end.yaw))
}

fn headings(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).into()).collect()
}

fn row(gait: &str, direction: Direction, survived: &[f64], limits: &[f64]) -> Vec<String> {
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let number = |value: f64| if value.is_finite() { format!("{value:.1}") } else { "–".into() };
    vec![
        gait.into(),
        format!("{direction:?}").to_lowercase(),
        number(least(survived)),
        format!("{:.2}", mean(survived)),
        number(least(limits)),
        number(mean(limits)),
        survived.iter().map(|value| format!("{value:.1}")).collect::<Vec<_>>().join(" "),
    ]
}
