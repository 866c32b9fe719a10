//! Arguments of `biped robustness`.

use crate::batch::BatchArgs;
use clap::Args;
use std::path::PathBuf;

/// Arguments of `biped robustness`.
#[derive(Args)]
pub struct RobustnessArgs {
    /// Scene whose commands are disturbed
    #[arg(default_value = "walk")]
    pub(super) scene: String,
    /// Replace a value of the scene (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub(super) settings: Vec<String>,
    /// Delays of every command, ascending [ms]; by default nine from 0 to 8
    #[arg(long, value_name = "MS,…", value_delimiter = ',')]
    pub(super) delay: Vec<f64>,
    /// Jitters, ascending [ms]; by default eight from 0 to 12. Their distribution is uniform, or that of --set link.jitter=normal or =burst
    #[arg(long, value_name = "MS,…", value_delimiter = ',')]
    pub(super) jitter: Vec<f64>,
    /// Probabilities that a command is lost, ascending; by default six from 0 to 0.8
    #[arg(long, value_name = "P,…", value_delimiter = ',')]
    pub(super) loss: Vec<f64>,
    /// Repeat the map for each value of a key, for example plant.friction=0.7,0.3 or plant.payload_kg=0,2 or
    /// plant.push_impulse=[0,2,0],[0,-2,0]; if repeated, for each combination
    #[arg(long, value_name = "KEY=V,…")]
    pub(super) with: Vec<String>,
    /// Runs of each cell, each with its own seed; 3 by default
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub(super) seeds: Option<u64>,
    /// A coarse map of short walks: takes seconds
    #[arg(long)]
    pub(super) quick: bool,
    #[command(flatten)]
    pub(super) batch: BatchArgs,
    /// Write the table and the map into this folder; runs that its table already contains are not repeated
    #[arg(long, value_name = "DIR", default_value = "out/robustness")]
    pub(super) out: PathBuf,
    #[arg(from_global)]
    pub(super) quiet: bool,
}
