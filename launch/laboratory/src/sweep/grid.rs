//! The list of runs: every combination of the values, numbered, and checked before the first run.

use super::args::SweepArgs;
use super::figures::{self, Survival};
use super::keys::{SEED, SEED_KEYS, axes, check_keys};
use crate::batch::axis::{Axis, combinations, refused, settings};
use crate::batch::table::Form;
use messages::load::{SceneError, load, text};
use messages::scene::Scene;
use messages::wire::{FNV_START, fnv1a};
use rayon::prelude::*;
use records::analysis::RunAnalysis;
use sessions::run::in_process;
use shared::args::settings_with_robot;
use shared::exit::{Exit, Failure};
use shared::list::SCENES;
use std::time::{Duration, Instant};

/// Most runs of a sweep.
const MOST_RUNS: usize = 100_000;
/// Computing time of the trial by which the duration of too large a sweep is estimated.
const TRIAL: Duration = Duration::from_millis(300);
/// A sweep.
pub struct Grid {
    name: String,
    /// Settings of every run.
    fixed: Vec<String>,
    /// The keys with their values. The one of `--edge` is the first, seeds are the last.
    pub axes: Vec<Axis>,
    /// Index of the value of each axis in each run.
    pub runs: Vec<Vec<usize>>,
    /// What the table contains.
    pub form: Form,
}

impl Grid {
    /// The sweep of the arguments.
    ///
    /// # Errors
    /// A bad argument, or a combination that is no valid scene.
    pub fn new(args: &SweepArgs) -> Result<Grid, Failure> {
        let fixed = settings_with_robot(&args.scene.robot, &args.scene.settings);
        let base = args.scene.load()?;
        let axes = axes(args)?;
        check_keys(&axes, &args.scene.settings)?;
        let count = axes.iter().fold(1, |count: usize, axis| count.saturating_mul(axis.values.len()));
        if count > MOST_RUNS {
            return Err(too_many(count, &base));
        }
        let mut grid =
            Grid { name: args.scene.scene.clone(), fixed, runs: combinations(&axes), axes, form: Form::default() };
        let check = |run: &Vec<usize>| {
            let scene = grid.scene(&grid.settings(run))?;
            Ok((fnv1a(FNV_START, text(&scene).as_bytes()), is_random(&scene)))
        };
        let scenes: Vec<Result<_, Failure>> = grid.runs.par_iter().map(check).collect();
        let scenes: Vec<(u64, bool)> = scenes.into_iter().collect::<Result<_, _>>()?; // the first failure, each time the same
        if grid.axes.last().is_some_and(|axis| axis.key == SEED) && !scenes.iter().any(|(_, random)| *random) {
            let words = format!(
                "nothing in {} is random; link.jitter_ms, link.loss, link.reorder, plant.stale_probability and plant.ground.random.height are",
                grid.name
            );
            return Err(refused("seeds", words));
        }
        if args.edge.is_some() {
            grid.check_edge(args, &base)?;
        }
        let hash = scenes.iter().fold(FNV_START, |hash, (scene, _)| fnv1a(hash, &scene.to_le_bytes()));
        grid.form = grid.form_of(hash);
        Ok(grid)
    }

    /// The axes of the drawing, and the runs of each of its cells: seeds are an axis only if there is no other.
    pub fn drawn(&self) -> (&[Axis], usize) {
        match self.axes.split_last() {
            Some((seeds, others)) if seeds.key == SEED && !others.is_empty() => (others, seeds.values.len()),
            _ => (&self.axes, 1),
        }
    }

    /// Title of the drawing.
    pub fn title(&self, survival: &Survival) -> String {
        format!("{}: no fall{}", self.name, survival.condition())
    }

    /// The settings of a run.
    pub fn settings(&self, run: &[usize]) -> Vec<String> {
        let all = settings(&self.axes, run).into_iter();
        all.flat_map(|setting| match setting.split_once('=') {
            Some((SEED, seed)) => SEED_KEYS.map(|key| format!("{key}={seed}")).to_vec(),
            _ => vec![setting],
        })
        .collect()
    }

    /// The scene with these settings.
    ///
    /// # Errors
    /// A bad setting.
    pub fn scene(&self, settings: &[String]) -> Result<Scene, Failure> {
        load(&self.name, &[&self.fixed, settings].concat(), SCENES).map_err(|error| match error {
            SceneError::Override { setting, reason } => refused(&setting, reason),
            error => error.into(),
        })
    }

    /// What the table of runs with this hash contains.
    fn form_of(&self, hash: u64) -> Form {
        let cells = |run: &Vec<usize>| self.axes.iter().zip(run).map(|(axis, k)| axis.values[*k].clone()).collect();
        let keys = self.axes.iter().map(|axis| axis.key.clone());
        let names: Vec<String> =
            ["run".into()].into_iter().chain(keys).chain(figures::names().map(String::from)).collect();
        let cells = self.runs.iter().map(cells).collect();
        Form::new("sweep", hash, cells, names.iter().map(String::as_str), figures::names().count())
    }

    /// Checks that the robot can fall, and that values between those of the range are valid.
    fn check_edge(&self, args: &SweepArgs, base: &Scene) -> Result<(), Failure> {
        if args.survival.is_none() && RunAnalysis::without_rows(base).robot.feet.is_none() {
            let words =
                format!("the robot of {} has no feet, so it cannot fall; --survival says what else counts", self.name);
            return Err(refused("--edge", words));
        }
        let key = &self.axes[0];
        let ends = [0, 1].map(|k| key.values[k].parse::<f64>().unwrap_or(f64::NAN));
        let between = format!("{}={}", key.key, 0.5 * (ends[0] + ends[1]));
        let others = self.settings(&self.runs[0]).split_off(1);
        self.scene(&[vec![between], others].concat()).map(|_| ())
    }
}

/// Whether a seed changes a run of the scene.
fn is_random(scene: &Scene) -> bool {
    let link = &scene.link;
    let heights = scene.plant.ground.random.height;
    let chances = [link.jitter_ms, link.loss, link.reorder, scene.plant.stale_probability, heights];
    chances.iter().any(|chance| *chance > 0.0)
}

/// The failure that reports too many runs, with the time that they would take.
fn too_many(count: usize, scene: &Scene) -> Failure {
    let (start, mut simulated) = (Instant::now(), 0.0);
    let _ = in_process(scene, |truth| {
        simulated = truth.stamp.time();
        let is_over = start.elapsed() > TRIAL;
        if is_over { Err(Failure::new(Exit::Ok, "the trial is over")) } else { Ok(()) }
    });
    let cores = rayon::current_num_threads();
    let seconds = start.elapsed().as_secs_f64() * scene.duration / f64::max(simulated, 1.0 / scene.rate);
    let hours = count as f64 * seconds / cores as f64 / 3600.0;
    let words = format!(
        "{count} runs would take about {hours:.1} h on {cores} processors, and a sweep has at most {MOST_RUNS}: give fewer values"
    );
    Failure::new(Exit::Usage, words)
}
