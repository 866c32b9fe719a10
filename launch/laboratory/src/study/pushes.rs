//! `biped study pushes`: how hard the robot may be pushed, by phase and direction, beside what a pendulum on its feet could bear.
//!
//! The impulse grows in steps until the first one fells the robot: what stays up beyond that does not count, for survival is not
//! monotonic. Then come long walks with pushes by chance, which punish what only bears a single one.

mod limit;
mod trial;

use super::{Study, StudyArgs, belongs_to, hand_out, table};
use clap::{Args, ValueEnum};
use limit::Pendulum;
use messages::load::load;
use messages::scene::Scene;
use rayon::prelude::*;
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use shared::progress::BatchProgress;
use std::f64::consts::{FRAC_1_SQRT_2, TAU};
use std::sync::atomic::AtomicBool;
pub use trial::{Push, disturbed};

/// What else `biped study pushes` can be asked.
#[derive(Args)]
pub struct PushArgs {
    /// Phases of a period at which the robot is pushed [12]; for `pushes`
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    phases: Option<u32>,
    /// Shift of all phases, as a share of their distance [0]; for `pushes`
    #[arg(long, value_name = "SHARE")]
    offset: Option<f64>,
    /// Directions [all]; for `pushes`
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    directions: Vec<Direction>,
    /// Seed of the long walks [1]; for `pushes`
    #[arg(long, value_name = "N")]
    seed: Option<u64>,
    /// A setting of both scenes, as for `run`; for `pushes`
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
}

impl PushArgs {
    /// # Errors
    /// What is asked of another study, and an offset that is none.
    pub fn check(&self, study: Study) -> Result<(), Failure> {
        let given = [
            ("--phases", self.phases.is_some()),
            ("--offset", self.offset.is_some()),
            ("--directions", !self.directions.is_empty()),
            ("--seed", self.seed.is_some()),
            ("--set", !self.settings.is_empty()),
        ];
        match (study, given.iter().find(|option| option.1)) {
            (Study::Pushes, _) | (_, None) => (),
            (_, Some((name, _))) => return Err(belongs_to(name, "pushes")),
        }
        if self.offset.is_some_and(|offset| !(0.0..1.0).contains(&offset)) {
            return Err(Failure::new(
                Exit::Usage,
                "--offset must be at least 0 and less than 1: a share of the phases' distance",
            ));
        }
        Ok(())
    }

    /// Times of the phases, as shares of a period.
    fn shares(&self) -> Vec<f64> {
        let (phases, offset) = (self.phases.unwrap_or(12), self.offset.unwrap_or(0.0));
        (0..phases).map(|k| (f64::from(k) + offset) / f64::from(phases)).collect()
    }
}

/// Whither it is pushed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Direction {
    /// Along x
    Forward,
    /// Against x
    Backward,
    /// Along y
    Left,
    /// Against y
    Right,
    /// Forward and left by equal shares
    Front,
    /// Backward and right by equal shares
    Rear,
}

impl Direction {
    /// As a unit vector in W.
    fn unit(self) -> [f64; 3] {
        let half = FRAC_1_SQRT_2;
        match self {
            Direction::Forward => [1.0, 0.0, 0.0],
            Direction::Backward => [-1.0, 0.0, 0.0],
            Direction::Left => [0.0, 1.0, 0.0],
            Direction::Right => [0.0, -1.0, 0.0],
            Direction::Front => [half, half, 0.0],
            Direction::Rear => [-half, -half, 0.0],
        }
    }
}

/// Gaits that are pushed.
const GAITS: [(&str, &str); 2] = [("walk", "walking"), ("stamp", "stepping in place")];
/// The first phase begins when the gait is steady [s].
const BEGIN: f64 = 4.5;
/// So long after the push the robot must still be up [s].
const AFTER: f64 = 6.0;
/// By how much the impulse grows, and how far [N·s].
const GROWTH: f64 = 0.5;
const GREATEST: f64 = 12.0;
/// A push lasts this long [s].
const DURATION: f64 = 0.05;
/// Long walks: how many, of which length [s], pushed how hard at most [N·s], every so often [s].
const WALKS: [(usize, f64, f64); 2] = [(10, 600.0, 3.0), (10, 120.0, 5.0)];
const EVERY: f64 = 5.0;

/// Runs all of it on all cores, prints the tables and writes them, if asked to.
///
/// # Errors
/// A bad setting, Ctrl-C, or a folder that cannot be written.
pub fn run(args: &StudyArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let asked = &args.pushes;
    let scenes: Vec<Scene> =
        GAITS.iter().map(|(name, _)| load(name, &asked.settings, SCENES)).collect::<Result<_, _>>()?;
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
    let borne: Vec<f64> = phases
        .par_iter()
        .map(|&(scene, direction, share)| borne(scene, direction, share, stop).inspect(|_| counter.add_done(1)))
        .collect::<Result<_, _>>()?;
    let ends: Vec<(Option<f64>, f64)> = walks
        .par_iter()
        .map(|&(duration, most, seed)| {
            let scene = Scene { duration, ..scenes[0].clone() };
            long_walk(&scene, most, seed, stop).inspect(|_| counter.add_done(1))
        })
        .collect::<Result<_, _>>()?;
    counter.finish();
    let mut singles = borne.chunks(shares.len());
    let mut rows = vec![headings(&["gait", "direction", "least", "mean", "limit, least", "limit, mean", "by phase"])];
    for (scene, (_, gait)) in scenes.iter().zip(GAITS) {
        let pendulum = Pendulum::of(scene, stop)?;
        for (&direction, borne) in directions.iter().zip(&mut singles) {
            let limits: Vec<f64> = shares.iter().map(|&share| pendulum.limit(direction, share)).collect();
            rows.push(row(gait, direction, borne, &limits));
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
    let text = format!("{}\n{}", table(&rows), table(&walked));
    hand_out(args, &text, &[("", csv::text(&rows)), ("-walks", csv::text(&walked))])
}

/// Greatest impulse [N·s] up to which every smaller one is borne, pushed `share` of a period after [`BEGIN`].
fn borne(scene: &Scene, direction: Direction, share: f64, stop: &AtomicBool) -> Result<f64, Failure> {
    let period = scene.controller.as_ref().map_or(0.0, |controller| controller.period);
    let time = BEGIN + share * period;
    let scene = Scene { duration: time + AFTER, ..scene.clone() };
    let mut borne = 0.0;
    while borne < GREATEST {
        let impulse = direction.unit().map(|part| part * (borne + GROWTH));
        if disturbed(&scene, &[Push { time, impulse }], stop)?.fall.is_some() {
            break;
        }
        borne += GROWTH;
    }
    Ok(borne)
}

/// When a walk fell [s] that is pushed by up to `most` [N·s] at random, and its greatest yaw [deg].
fn long_walk(scene: &Scene, most: f64, seed: u64, stop: &AtomicBool) -> Result<(Option<f64>, f64), Failure> {
    let mut random = fastrand::Rng::with_seed(seed);
    let count = ((scene.duration - BEGIN) / EVERY) as usize;
    let push = |k| {
        let (angle, size) = (TAU * random.f64(), most * random.f64());
        let time = BEGIN + EVERY * k as f64 + random.f64();
        Push { time, impulse: [size * angle.cos(), size * angle.sin(), 0.0] }
    };
    let pushes: Vec<Push> = (0..count).map(push).collect();
    let end = disturbed(scene, &pushes, stop)?;
    Ok((end.fall, end.yaw))
}

fn headings(names: &[&str]) -> Vec<String> {
    names.iter().map(|name| (*name).into()).collect()
}

fn row(gait: &str, direction: Direction, borne: &[f64], limits: &[f64]) -> Vec<String> {
    let least = |values: &[f64]| values.iter().copied().fold(f64::INFINITY, f64::min);
    let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
    let number = |value: f64| if value.is_finite() { format!("{value:.1}") } else { "–".into() };
    vec![
        gait.into(),
        format!("{direction:?}").to_lowercase(),
        number(least(borne)),
        format!("{:.2}", mean(borne)),
        number(least(limits)),
        number(mean(limits)),
        borne.iter().map(|value| format!("{value:.1}")).collect::<Vec<_>>().join(" "),
    ]
}
