//! Arguments of `biped sweep`.

use crate::batch::BatchArgs;
use clap::Args;
use shared::args::SceneArgs;
use std::path::PathBuf;

/// Arguments of `biped sweep`.
#[derive(Args)]
pub struct SweepArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    /// Keys with their values (see `biped list --keys`): a list a,b,c, a range a:b:n of n values from a to b, or log:a:b:n. The
    /// scene is run with every combination. seeds=N repeats each with the seeds 1 to N of
    /// its random numbers: link.seed, plant.seed and plant.ground.random.seed
    #[arg(value_name = "KEY=RANGE", required_unless_present = "edge")]
    pub(super) ranges: Vec<String>,
    /// Find the values of a key at which survival changes: compare 21 values from a to b (or n, with a:b:n), then bisect each change
    #[arg(long, value_name = "KEY=A:B")]
    pub(super) edge: Option<String>,
    /// Bisect until a threshold is known to this accuracy, in the unit of its key; a thousandth of the range by default
    #[arg(long, value_name = "VALUE", requires = "edge")]
    pub(super) tolerance: Option<f64>,
    /// Condition of survival in addition to not falling: a key of summary.json below or above a limit, for example
    /// 'distance_m<0.001'
    #[arg(long, value_name = "CONDITION")]
    pub(super) survival: Option<String>,
    #[command(flatten)]
    pub(super) batch: BatchArgs,
    /// Write tables and figures into this folder; runs that its table already contains are not repeated
    #[arg(long, value_name = "DIR", default_value = "out/sweep")]
    pub(super) out: PathBuf,
    #[arg(from_global)]
    pub(super) quiet: bool,
}
