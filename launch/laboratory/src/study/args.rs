//! Arguments of `biped study`.

use clap::builder::NonEmptyStringValueParser;
use clap::{Args, ValueEnum};
use shared::exit::{Exit, Failure};
use std::f64::consts::FRAC_1_SQRT_2;
use std::path::PathBuf;

/// Arguments of `biped study`.
#[derive(Args)]
pub struct StudyArgs {
    /// Study to run
    pub(super) study: Study,
    /// Write the table into this folder, as Markdown and as CSV
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    #[arg(from_global)]
    pub(super) quiet: bool,
    /// For `problems`: number of contact problems, all families together; 1000000 by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    pub(super) count: Option<u64>,
    #[command(flatten)]
    pub(super) pushes: PushArgs,
}

/// The studies of `biped study`.
#[derive(Clone, Copy, Debug, ValueEnum)]
pub enum Study {
    /// Tolerance of the walk against errors of the robot, its sensors and the ground
    Margins,
    /// The walk under each contact law
    Laws,
    /// Return of the lateral motion to its periodic orbit after a push, with and without the energy rule (39)
    Attraction,
    /// Walks of up to ten minutes
    Endurance,
    /// Accuracy and cost of the solutions of random contact problems of many families
    Problems,
    /// Greatest push without a fall, beside the limit of an inverted pendulum with feet
    Pushes,
}

/// Further options of `biped study pushes`.
#[derive(Args)]
pub struct PushArgs {
    /// For `pushes`: number of phases of a period at which the robot is pushed; 12 by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub(super) phases: Option<u32>,
    /// For `pushes`: shift of all phases, as a share of the interval between two of them; 0 by default
    #[arg(long, value_name = "SHARE")]
    pub(super) offset: Option<f64>,
    /// For `pushes`: directions, separated by commas; all by default
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub(super) directions: Vec<Direction>,
    /// For `pushes`: seed of the long walks with random pushes; 1 by default
    #[arg(long, value_name = "N")]
    pub(super) seed: Option<u64>,
    /// For `pushes`: use the robot of this TOML or URDF file, and pushes that are scaled to it
    #[arg(long, value_name = "FILE", value_parser = NonEmptyStringValueParser::new())]
    pub(super) robot: Option<String>,
    /// For `pushes`: replace a value of both scenes, the walk and the steps in place; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) settings: Vec<String>,
}

/// Keys that `study pushes` sets itself, and what else to do.
const OWN_KEYS: [(&str, &str); 8] = [
    ("duration", LASTS),
    ("plant.push_time", "use --phases and --offset"),
    ("plant.push_impulse", "use --directions"),
    ("plant.push_duration", "every push lasts 0.05 s"),
    ("plant.push_body", "every push is of the base"),
    ("controller.speed", GAITS),
    ("controller.gait", GAITS),
    ("controller.stop_time", LASTS),
];
const LASTS: &str = "every walk lasts until some time after its last push";
const GAITS: &str = "the robot walks and steps in place";

/// True if the keys name the same value, or one of them a part of the other.
fn overlap(one: &str, other: &str) -> bool {
    let holds =
        |whole: &str, part: &str| part.strip_prefix(whole).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'));
    holds(one, other) || holds(other, one)
}

impl PushArgs {
    /// # Errors
    /// Refuses these options for other studies, a key that the study sets itself, and an offset outside its range.
    pub fn check(&self, study: Study) -> Result<(), Failure> {
        let given = [
            ("--phases", self.phases.is_some()),
            ("--offset", self.offset.is_some()),
            ("--directions", !self.directions.is_empty()),
            ("--seed", self.seed.is_some()),
            ("--robot", self.robot.is_some()),
            ("--set", !self.settings.is_empty()),
        ];
        match (study, given.iter().find(|option| option.1)) {
            (Study::Pushes, _) | (_, None) => (),
            (_, Some((name, _))) => return Err(belongs_to(name, "pushes")),
        }
        for setting in &self.settings {
            let key = setting.split('=').next().unwrap_or_default().trim();
            if let Some((own, instead)) = OWN_KEYS.iter().find(|(own, _)| overlap(own, key)) {
                let words = format!("--set {setting}: `study pushes` sets {own} itself: {instead}");
                return Err(Failure::new(Exit::Usage, words));
            }
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
    pub fn shares(&self) -> Vec<f64> {
        let (phases, offset) = (self.phases.unwrap_or(12), self.offset.unwrap_or(0.0));
        (0..phases).map(|k| (f64::from(k) + offset) / f64::from(phases)).collect()
    }
}

/// Direction of a push.
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
    pub fn unit(self) -> [f64; 3] {
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

/// The failure of an option that the study does not have.
pub fn belongs_to(option: &str, study: &str) -> Failure {
    Failure::new(Exit::Usage, format!("{option} works only with `study {study}`; the other studies have fixed cases"))
}
