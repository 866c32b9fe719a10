//! Arguments of `biped chart`.

use clap::Args;
use std::path::PathBuf;

/// Arguments of `biped chart`.
#[derive(Args)]
pub struct ChartArgs {
    /// Write the table, the drawings and the page into this folder
    #[arg(long, value_name = "DIR", default_value = "out/chart")]
    pub(super) out: PathBuf,
    /// Coarse steps and few of them: everything is drawn, within a minute
    #[arg(long)]
    pub(super) quick: bool,
    /// Measure other engines too, installed into a virtual environment of Python; or take a table of them, or a folder of their runs
    #[arg(long, value_name = "PATH", num_args = 0..=1, require_equals = true)]
    pub(super) peers: Option<Option<PathBuf>>,
    /// Instead of all that: how the time of a step grows with contacts, links and step length, and what processors bring
    #[arg(long)]
    pub(super) growth: bool,
    /// Instead: order, error and cost of every integration method in each kind of motion
    #[arg(long, conflicts_with_all = ["growth", "peers"])]
    pub(super) orders: bool,
    /// Only these comparison scenes, separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    pub(super) scenes: Vec<String>,
    /// Show no progress
    #[arg(long)]
    pub(super) quiet: bool,
}
