//! `biped`: one program, three roles. It starts plant and controller as processes of their own and watches over them;
//! as `biped plant` and `biped controller` it is either of them.
//!
//! | what | where |
//! |---|---|
//! | the main job | [`run`] |
//! | plant and controller by themselves | [`roles`] |
//! | tables of many runs | [`study`] |
//! | speed against accuracy | [`chart`] |
//! | how much delay, jitter and loss it bears | [`robustness`] |
//! | latency and jitter | [`latency`] |
//! | starting, watching and ending processes | [`children`] |
//! | real-time scheduling, and what grants it where | [`realtime`], [`place`] |
//! | what the system must allow | [`allowance`] |
//! | progress bar and live line | [`progress`] |
//! | scenes, their keys and their bits | [`list`], [`hashes`] |
//! | what goes wrong, exit codes; what is written | [`exit`], [`output`] |
//! | another controller amid the walk | [`swap`] |
//! | the wire format for other languages | [`wire`] |
//! | plant and controller on two machines | [`tunnel`] |
//! | the robot for other programs | [`export`] |
//! | asking a running session | [`desk`] |
//! | whether somebody else's program keeps to the wire | [`conform`] |
//! | what a fuzzer calls in the place of `main` | `fuzz` |
//! | faults on purpose, a long time | [`faults`], [`soak`] |
//! | this machine, and what is left on it | [`doctor`] |
//! | contact problems as files | [`contact`] |
//! | how large a model is, and what a smaller one saves | [`model`] |
//! | recordings and their replay | [`recording`] |
//! | the run in 3-D, in the terminal | [`view`], [`top`] |
//! | what a run leaves: record, summary, report | [`record`], [`summary`], [`csv`], [`report`] |

#![cfg_attr(fuzzing, no_main, allow(dead_code, reason = "the fuzzer begins elsewhere"))]

mod allowance;
mod chart;
mod children;
mod conform;
mod contact;
mod csv;
mod desk;
mod doctor;
mod exit;
mod export;
mod faults;
#[cfg(fuzzing)]
mod fuzz;
mod hashes;
mod latency;
mod list;
mod model;
mod output;
mod place;
mod progress;
mod realtime;
mod record;
mod recording;
mod report;
mod robustness;
mod roles;
mod run;
mod soak;
mod study;
mod summary;
mod swap;
mod top;
mod tunnel;
mod view;
mod wire;

use clap::{Args, Parser, Subcommand};
use exit::{Exit, Failure};
use messages::load::load;
use messages::port::{Pace, PortError};
use messages::scene::Scene;
use nix::sys::signal::{SigSet, Signal};
use output::{brief, tell};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::sync::mpsc;
use std::time::Duration;

/// Walks an eight-axis biped robot, plant and controller in two processes. Without a command: `run walk --out out/walk`.
#[derive(Parser)]
#[command(version, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// What every run does that is not on the smallest model: keep the model that the scene names
    #[arg(long, global = true, hide = true)]
    full: bool,
    /// Show no progress
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene: start both processes, show progress, sum up
    Run(run::RunArgs),
    /// Run the cases of a table, in parallel, and write it
    Study(study::StudyArgs),
    /// Chart speed against accuracy: every law, integrator and model size, beside other engines
    Chart(chart::ChartArgs),
    /// Map how much delay, jitter and loss of commands the walk bears
    Robustness(robustness::RobustnessArgs),
    /// Measure latency and jitter of the link, and of the walk over it, beside the limits of the host
    Latency(latency::LatencyArgs),
    /// The other process of `latency`
    #[command(hide = true)]
    LatencyPeer(latency::PeerArgs),
    /// Say how large the model of a scene is, how large the smallest that gives the same answer, and what that costs
    Model(SceneArgs),
    /// Solve the contact problem that a run could not solve, by every law
    Contact(contact::ContactArgs),
    /// Be the plant of a session
    Plant(roles::RoleArgs),
    /// Be the controller of a session
    Controller(roles::RoleArgs),
    #[command(flatten)]
    Desk(desk::Wish),
    /// Show a running session in a browser, in 3-D, and let it be pushed and led from there; or a recording
    View(view::ViewArgs),
    /// Show how a running session is, in the terminal
    Top(top::TopArgs),
    /// Check whether a controller or plant of yours keeps to the rules of the wire
    Conform(conform::ConformArgs),
    /// Hurt real processes in many ways, and check that nothing hangs, lies or is left
    Faults(faults::FaultsArgs),
    /// Walk for a long time, and watch memory, open files, shared memory and latency
    Soak(soak::SoakArgs),
    /// Say whether this machine is fit to run, what is running, and what dead sessions left
    Doctor,
    /// Remove what dead sessions left in shared memory
    Clean,
    /// Carry a session to another machine
    Tunnel(tunnel::TunnelArgs),
    /// Print the wire format, for controllers and plants in other languages
    Wire(wire::WireArgs),
    /// Print the robot of a scene for other programs
    Export(export::ExportArgs),
    /// Be somebody else's program
    #[command(hide = true)]
    Become(children::BecomeArgs),
    /// Say what a recording has
    Info(recording::info::InfoArgs),
    /// Make tables of a recording
    Convert(recording::table::ConvertArgs),
    /// Feed recorded sensors to a controller, or recorded torques to a plant, and compare
    Replay(recording::replay::ReplayArgs),
    /// List the built-in scenes
    List {
        /// List every key of a scene instead: type, default, meaning
        #[arg(long)]
        keys: bool,
        /// List the hashes of the states that every scene runs through
        #[arg(long, conflicts_with = "keys")]
        hashes: bool,
    },
}

/// Which scene, and what is different in it.
#[derive(Args, Clone)]
struct SceneArgs {
    /// Built-in scene (see `biped list`) or path of a TOML file
    scene: String,
    /// Put the robot of this TOML or URDF file into the scene, which is fitted to it; `biped export toml` prints one to edit
    #[arg(long, value_name = "FILE")]
    robot: Option<String>,
    /// Replace a value of the scene, for example plant.friction=0.3 (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
}

impl SceneArgs {
    fn load(&self) -> Result<Scene, Failure> {
        Ok(load(&self.scene, &fitted(&self.robot, &self.settings), list::SCENES)?)
    }
}

/// The settings of a scene, its robot before all others.
fn fitted(robot: &Option<String>, settings: &[String]) -> Vec<String> {
    robot.iter().map(|path| format!("robot={path}")).chain(settings.iter().cloned()).collect()
}

/// How the two processes speak.
#[derive(Args, Clone, Copy)]
struct PaceArgs {
    /// Run at the pace of the clock instead of as fast as possible
    #[arg(long)]
    realtime: bool,
    /// Simulated time per real time
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = factor, requires = "realtime")]
    speed: f64,
    /// Give up when the other process has not been heard of for this long [s]
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = seconds)]
    patience: f64,
}

impl PaceArgs {
    fn pace(self) -> Pace {
        if self.realtime { Pace::RealTime } else { Pace::Lockstep }
    }

    fn patience(self) -> Duration {
        Duration::from_secs_f64(self.patience)
    }
}

fn factor(text: &str) -> Result<f64, String> {
    let good = text.parse().ok().filter(|factor| (0.001..=100.0).contains(factor));
    good.ok_or_else(|| "a factor from 0.001 to 100 is needed".into())
}

fn seconds(text: &str) -> Result<f64, String> {
    let good = text.parse().ok().filter(|seconds| (0.1..=1e6).contains(seconds));
    good.ok_or_else(|| "a number of seconds from 0.1 to 1000000 is needed".into())
}

fn main() -> ExitCode {
    // A file that reaches the limit of `ulimit -f` is an error like a full disk, and no death.
    let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    if let Err(error) = ctrlc::set_handler(move || asked.store(true, Relaxed)) {
        tell(format_args!("Ctrl-C will not end this in order: {error}"));
    }
    match obey(Cli::parse(), &stop) {
        Ok(()) => Exit::Ok.into(),
        Err(failure) => {
            let case = failure.case.map_or(String::new(), |case| case.keep());
            tell(format_args!("error: {}{case}", brief(&failure.message)));
            failure.exit.into()
        }
    }
}

/// Does what was asked for.
fn obey(Cli { command, quiet, .. }: Cli, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    allowance::check()?;
    match command {
        Some(Command::Run(args)) => run::run(&args, stop),
        Some(Command::Study(args)) => study::run(&args, stop),
        Some(Command::Chart(args)) => chart::run(&args, stop),
        Some(Command::Robustness(args)) => robustness::run(&args, stop),
        Some(Command::Latency(args)) => latency::run(&args, stop),
        Some(Command::LatencyPeer(args)) => latency::peer(&args, stop),
        Some(Command::Model(args)) => model::run(&args),
        Some(Command::Contact(args)) => contact::run(&args),
        Some(Command::Plant(args)) => roles::plant(&args, stop),
        Some(Command::Controller(args)) => roles::controller(&args, stop),
        Some(Command::Desk(wish)) => desk::run(wish),
        Some(Command::View(args)) => view::run(&args, stop),
        Some(Command::Top(args)) => top::run(&args, stop),
        Some(Command::Conform(args)) => conform::run(&args, stop),
        Some(Command::Faults(args)) => faults::run(&args, stop),
        Some(Command::Soak(args)) => soak::run(&args, stop),
        Some(Command::Doctor) => doctor::doctor(),
        Some(Command::Clean) => doctor::clean(),
        Some(Command::Wire(args)) => {
            wire::run(&args);
            Ok(())
        }
        Some(Command::Tunnel(args)) => tunnel::run(&args, stop),
        Some(Command::Become(args)) => children::become_other(&args),
        Some(Command::Export(args)) => export::run(&args),
        Some(Command::Info(args)) => recording::info::run(&args, stop),
        Some(Command::Convert(args)) => recording::table::run(&args, stop),
        Some(Command::Replay(args)) => recording::replay::run(&args, stop),
        Some(Command::List { hashes: true, .. }) => hashes::print(),
        Some(Command::List { keys: false, .. }) => list::scenes(),
        Some(Command::List { keys: true, .. }) => list::keys(),
        None => run::run(&run::RunArgs::main_job(quiet), stop),
    }
}

/// Opening a session takes milliseconds; but the remains of a process killed at the wrong instant can block it for
/// ever, so it gets 3 s before this process ends itself with advice.
fn guarded<T>(open: impl FnOnce() -> Result<T, PortError>) -> Result<T, PortError> {
    let (done, waiting) = mpsc::channel::<()>();
    std::thread::spawn(move || {
        if waiting.recv_timeout(Duration::from_secs(3)) == Err(mpsc::RecvTimeoutError::Timeout) {
            tell(format_args!(
                "error: shared memory: the session could not be opened within 3 s; another --session will work"
            ));
            std::process::exit(Exit::SharedMemory as i32);
        }
    });
    let opened = open();
    drop(done);
    opened
}
