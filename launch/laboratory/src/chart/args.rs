//! Arguments of `biped chart`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `biped chart`.
#[derive(Args)]
pub struct ChartArgs {
    /// Write the table, the drawings and the page into this folder
    #[arg(long, value_name = "DIR", default_value = "out/chart")]
    pub(super) out: PathBuf,
    /// Few and coarse steps: makes every drawing within a minute
    #[arg(long)]
    pub(super) quick: bool,
    /// Also measure other engines, installed into a Python virtual environment; or read a table or a folder of their runs
    #[arg(long, value_name = "PATH", num_args = 0..=1, require_equals = true)]
    pub(super) peers: Option<Option<PathBuf>>,
    /// Measure instead how the time of a step grows with contacts, links and step length, and the throughput of several processors
    #[arg(long)]
    pub(super) growth: bool,
    /// Measure instead order, error and cost of every integration method in each kind of motion
    #[arg(long, conflicts_with_all = ["growth", "peers"])]
    pub(super) orders: bool,
    /// Only these comparison scenes, separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) scenes: Vec<String>,
    #[arg(from_global)]
    pub(super) quiet: bool,
}
