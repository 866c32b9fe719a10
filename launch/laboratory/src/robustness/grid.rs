//! The list of runs: every combination of the axes, numbered.

use super::args::RobustnessArgs;
use super::results;
use crate::batch::axis::{Axis, combinations, refused, settings};
use crate::batch::table::Form;
use messages::load::{load, text, validate};
use messages::scene::{LinkScene, Scene};
use messages::wire::{FNV_START, fnv1a};
use shared::exit::{Exit, Failure};
use shared::list::SCENES;

/// Axes of a sweep, each ascending.
pub struct LinkGrid {
    /// Delays [ms].
    pub delays: Vec<f64>,
    /// Jitters [ms].
    pub jitters: Vec<f64>,
    /// Losses [-].
    pub losses: Vec<f64>,
    /// Variations of the scene.
    pub variations: Vec<Variation>,
    /// Runs of each cell.
    pub seeds: u64,
}

/// The scene with other values.
pub struct Variation {
    /// Changed settings; empty for the scene itself.
    pub name: String,
    /// The scene.
    pub scene: Scene,
}

/// One run.
pub struct SweepRun<'a> {
    /// Variation of the scene.
    pub variation: &'a Variation,
    /// Disturbance of the commands in this run.
    pub link: LinkScene,
}

/// Columns of the table that name a run.
const KEYS: [&str; 7] = ["case", "with", "delay_ms", "jitter_ms", "jitter", "loss", "seed"];
/// Default axes, and quick ones with the duration of their walks.
const DELAYS: [f64; 9] = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0];
const JITTERS: [f64; 8] = [0.0, 1.0, 2.0, 3.0, 4.0, 6.0, 8.0, 12.0];
const LOSSES: [f64; 6] = [0.0, 0.2, 0.4, 0.6, 0.7, 0.8];
const SEEDS: u64 = 3;
const QUICK: ([f64; 4], [f64; 2], [f64; 2], u64) = ([0.0, 2.0, 4.0, 8.0], [0.0, 6.0], [0.0, 0.8], 1);
const QUICK_DURATION: &str = "duration=6";

impl LinkGrid {
    /// The grid of the arguments.
    ///
    /// # Errors
    /// A bad argument.
    pub fn new(args: &RobustnessArgs) -> Result<LinkGrid, Failure> {
        let (delays, jitters, losses, seeds) = match args.quick {
            true => (&QUICK.0[..], &QUICK.1[..], &QUICK.2[..], QUICK.3),
            false => (&DELAYS[..], &JITTERS[..], &LOSSES[..], SEEDS),
        };
        let grid = LinkGrid {
            delays: axis("--delay", &args.delay, delays)?,
            jitters: axis("--jitter", &args.jitter, jitters)?,
            losses: axis("--loss", &args.loss, losses)?,
            variations: variations(args)?,
            seeds: args.seeds.unwrap_or(seeds),
        };
        // The worst link of the grid. If this scene is valid, all are.
        for variation in &grid.variations {
            let last = |axis: &[f64]| axis.last().copied().unwrap_or_default();
            let first = |axis: &[f64]| axis.first().copied().unwrap_or_default();
            for end in [first, last] {
                let (delay_ms, jitter_ms, loss) = (end(&grid.delays), end(&grid.jitters), end(&grid.losses));
                let link = LinkScene { delay_ms, jitter_ms, loss, ..variation.scene.link.clone() };
                validate(&Scene { link, ..variation.scene.clone() }, &format!("scene {}", args.scene))?;
            }
        }
        Ok(grid)
    }

    /// Every run, in the order of the table. The index of a run is its number.
    pub fn cases(&self) -> Vec<SweepRun<'_>> {
        let mut cases = Vec::new();
        for variation in &self.variations {
            for &loss in &self.losses {
                for &jitter_ms in &self.jitters {
                    for &delay_ms in &self.delays {
                        for seed in 1..=self.seeds {
                            let link = LinkScene { delay_ms, jitter_ms, loss, seed, ..variation.scene.link.clone() };
                            cases.push(SweepRun { variation, link });
                        }
                    }
                }
            }
        }
        cases
    }

    /// What the table contains.
    pub fn form(&self) -> Form {
        let key = |case: &SweepRun| {
            let link = &case.link;
            let jitter = format!("{:?}", link.jitter).to_lowercase();
            let [delay, spread, loss, seed] =
                [&link.delay_ms as &dyn ToString, &link.jitter_ms, &link.loss, &link.seed].map(ToString::to_string);
            vec![case.variation.name.clone(), delay, spread, jitter, loss, seed]
        };
        let names = KEYS.into_iter().chain(results::NAMES);
        Form::new("robustness", self.hash(), self.cases().iter().map(key).collect(), names, results::NAMES.len())
    }

    /// A hash of axes and scenes.
    fn hash(&self) -> u64 {
        let axes = format!("{:?}{:?}{:?}{}", self.delays, self.jitters, self.losses, self.seeds);
        let scenes = self.variations.iter().map(|variation| text(&variation.scene));
        scenes.fold(fnv1a(FNV_START, axes.as_bytes()), |hash, scene| fnv1a(hash, scene.as_bytes()))
    }
}

impl SweepRun<'_> {
    /// The scene to run.
    pub fn scene(&self) -> Scene {
        Scene { link: self.link.clone(), ..self.variation.scene.clone() }
    }
}

/// Checks that the values of an axis ascend.
fn axis(name: &str, wished: &[f64], usual: &[f64]) -> Result<Vec<f64>, Failure> {
    let values = if wished.is_empty() { usual } else { wished };
    match values.windows(2).find(|pair| pair[0].partial_cmp(&pair[1]) != Some(std::cmp::Ordering::Less)) {
        Some(pair) => {
            let message = format!("{name}: {} comes before {}, but values must ascend", pair[0], pair[1]);
            Err(Failure::new(Exit::Usage, message))
        }
        None => Ok(values.to_vec()),
    }
}

/// Every combination of the values of `--with`.
fn variations(args: &RobustnessArgs) -> Result<Vec<Variation>, Failure> {
    let axes =
        args.with.iter().map(|wish| Axis::parse(wish).map_err(|words| refused(&format!("--with {wish}"), words)));
    let axes: Vec<Axis> = axes.collect::<Result<_, _>>()?;
    let quick = args.quick.then(|| QUICK_DURATION.to_string());
    let fixed: Vec<_> = quick.into_iter().chain(args.settings.iter().cloned()).collect();
    let scene = |settings: &[String]| -> Result<Scene, Failure> {
        let scene = load(&args.scene, &[&fixed, settings].concat(), SCENES)?;
        match scene.controller {
            Some(_) => Ok(scene),
            None => {
                let message = format!("{} has no controller, so there are no commands to disturb", args.scene);
                Err(Failure::new(Exit::Usage, message))
            }
        }
    };
    let variation = |settings: Vec<String>| Ok(Variation { name: settings.join(" "), scene: scene(&settings)? });
    combinations(&axes).iter().map(|combination| variation(settings(&axes, combination))).collect()
}
