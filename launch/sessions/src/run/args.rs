//! Arguments of `biped run`.

use crate::realtime::RealtimeArgs;
use crate::share::ShareArgs;
use crate::swap::Swap;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use messages::legible;
use records::recording::RecordArgs;
use shared::args::{DEFAULT_PATIENCE, PaceArgs, SceneArgs};
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
    /// Name of the session, for `biped pause`, `push` and other requests; by default a unique name
    #[arg(long, conflicts_with = "in_process")]
    pub(super) session: Option<String>,
    #[command(flatten)]
    pub(super) share: ShareArgs,
    /// Restart a crashed plant or controller, at most this many times. A new plant starts a new run; a new controller
    /// continues the walk within the step
    #[arg(long, default_value_t = 0, value_name = "TIMES", conflicts_with = "in_process")]
    pub(super) respawn: u32,
    /// Program of yours to use as the controller, with its arguments. Environment variables name the session to it, see docs/WIRE.md
    #[arg(long, value_name = "COMMAND", conflicts_with = "in_process", value_parser = NonEmptyStringValueParser::new())]
    pub(super) controller: Option<String>,
    /// Program of yours to use as the plant, with its arguments: another simulator, or the driver of a robot
    #[arg(long, value_name = "COMMAND", conflicts_with = "in_process", value_parser = NonEmptyStringValueParser::new())]
    pub(super) plant: Option<String>,
    /// Let another controller take over at this simulated time while the robot walks. COMMAND is as for --controller; `biped
    /// controller` is the built-in one; repeatable
    #[arg(long, value_name = "SECONDS=COMMAND", conflicts_with = "in_process")]
    pub(super) swap: Vec<Swap>,
    #[arg(from_global)]
    pub(super) quiet: bool,
    /// Run plant and controller in one process, by function calls: the same results in less time
    #[arg(long, conflicts_with_all = ["realtime", "cpu", "speed", "patience"])]
    pub(super) in_process: bool,
    /// Simulate the smallest equivalent model of the scene, see `biped model`. Needs --in-process, where no request can push the robot in a
    /// direction that this model does not have
    #[arg(long, requires = "in_process", conflicts_with = "full")]
    pub(super) smallest: bool,
}

impl RunArgs {
    /// The foreign programs of the run: how the option that names each begins, and its command.
    pub(super) fn programs(&self) -> Vec<(String, String)> {
        let roles = [("--plant ", &self.plant), ("--controller ", &self.controller)];
        let roles = roles.into_iter().filter_map(|(option, command)| Some((option.to_string(), command.clone()?)));
        let swaps = self.swap.iter().map(|swap| (format!("--swap {}=", legible(swap.time)), swap.command.clone()));
        roles.chain(swaps).collect()
    }

    /// The run of `biped` without arguments: `run walk --out out/walk`.
    pub fn default_run(quiet: bool) -> RunArgs {
        RunArgs {
            scene: SceneArgs { scene: "walk".into(), robot: None, settings: vec![] },
            pace: PaceArgs { realtime: false, speed: 1.0, patience: DEFAULT_PATIENCE },
            system: RealtimeArgs::default(),
            session: None,
            share: ShareArgs::default(),
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
