//! Arguments of `biped run`.

use crate::realtime::RealtimeArgs;
use crate::swap::Swap;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use records::recording::RecordArgs;
use shared::args::{PaceArgs, SceneArgs};
use std::path::PathBuf;

/// Arguments of `biped run`.
#[derive(Args)]
pub struct RunArgs {
    #[command(flatten)]
    pub(super) scene: SceneArgs,
    #[command(flatten)]
    pub(super) pace: PaceArgs,
    #[command(flatten)]
    pub(super) system: RealtimeArgs,
    /// Write summary, trajectory and report into this folder
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    #[command(flatten)]
    pub(super) record: RecordArgs,
    /// Name of the session, for `biped pause`, `push` and the like; without it, one that nobody else has
    #[arg(long, conflicts_with = "in_process")]
    pub(super) session: Option<String>,
    /// Start a plant or controller that dies anew, up to so many times: a new plant begins anew, a new controller goes on
    /// amid the step
    #[arg(long, default_value_t = 0, value_name = "TIMES", conflicts_with = "in_process")]
    pub(super) respawn: u32,
    /// Program to be the controller, with its arguments: it finds the session in its environment, see docs/WIRE.md
    #[arg(long, value_name = "COMMAND", conflicts_with = "in_process", value_parser = NonEmptyStringValueParser::new())]
    pub(super) controller: Option<String>,
    /// Program to be the plant, likewise: another simulator, or a robot's driver
    #[arg(long, value_name = "COMMAND", conflicts_with = "in_process", value_parser = NonEmptyStringValueParser::new())]
    pub(super) plant: Option<String>,
    /// Let another controller take over at this simulated time, as the robot walks on; COMMAND as for --controller, `biped
    /// controller` being ours; repeatable
    #[arg(long, value_name = "SECONDS=COMMAND", conflicts_with = "in_process")]
    pub(super) swap: Vec<Swap>,
    /// Show no progress
    #[arg(long)]
    pub(super) quiet: bool,
    /// Run plant and controller in this process, by plain calls: the same results
    #[arg(long, conflicts_with_all = ["realtime", "cpu"])]
    pub(super) in_process: bool,
    /// Simulate the smallest model that gives the answer of the scene, see `biped model`. In this process alone, where nobody can push: a
    /// push could ask for a direction that this model does not have
    #[arg(long, requires = "in_process", conflicts_with = "full")]
    pub(super) smallest: bool,
}

impl RunArgs {
    /// What `biped` does without arguments.
    pub fn main_job(quiet: bool) -> RunArgs {
        RunArgs {
            scene: SceneArgs { scene: "walk".into(), robot: None, settings: vec![] },
            pace: PaceArgs { realtime: false, speed: 1.0, patience: 10.0 },
            system: RealtimeArgs::default(),
            session: None,
            respawn: 0,
            controller: None,
            plant: None,
            swap: vec![],
            out: Some("out/walk".into()),
            record: RecordArgs::default(),
            quiet,
            in_process: false,
            smallest: false,
        }
    }
}
