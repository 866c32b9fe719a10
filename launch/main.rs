//! The program `biped`. `biped run` starts plant and controller as two child processes and monitors them. Each child is this program
//! too, as `biped plant` and `biped controller`.
//!
//! | crate | contents |
//! |---|---|
//! | [`shared`] | shared by all commands: arguments, built-in scenes, exit codes, output, progress |
//! | [`records`] | the results of a run: summary, report, recordings, 3-D page, terminal display |
//! | [`sessions`] | plant and controller as processes: starting, monitoring, controlling, swapping, ending |
//! | [`laboratory`] | measurements: accuracy, speed, latency, robustness, fault injection, conformance |

#![cfg_attr(fuzzing, no_main, allow(dead_code, reason = "the fuzzer has its own entry point"))]

mod arguments;
#[cfg(fuzzing)]
mod fuzz;
mod help;

use clap::{FromArgMatches, Parser, Subcommand};
use laboratory::{chart, conform, contact, faults, hashes, latency, robustness, soak, study, sweep};
use nix::sys::signal::{SigSet, Signal};
use records::{recording, top, view};
use sessions::{
    children, control, doctor, environment, export, model, resource_limits, roles, run, scaffold, tunnel, wire,
};
use shared::args::SceneArgs;
use shared::exit::{self, Exit, Failure};
use shared::interrupt;
use shared::list;
use shared::output::{log, shortened};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// Simulates and controls an eight-axis biped robot, with plant and controller as two processes. Without a command: `run walk --out out/walk`.
#[derive(Parser)]
#[command(version, after_help = exit::Exit::table())]
struct Cli {
    #[command(subcommand)]
    command: Option<CliCommand>,
    /// Simulate the scene's own model, the default; opposite of --smallest
    #[arg(long, global = true, hide = true)]
    full: bool,
    /// Show no progress
    #[arg(long, global = true)]
    quiet: bool, // commands that show progress read it by `from_global`
}

#[derive(Subcommand)]
enum CliCommand {
    /// Run a scene: start both processes, show progress, print a summary
    Run(run::RunArgs),
    /// Print the tables of docs/PAPER.md, or solve random contact problems: sets of runs in parallel
    Study(study::StudyArgs),
    /// Chart speed against accuracy for contact laws, integration methods and model sizes, optionally beside other simulators
    Chart(chart::ChartArgs),
    /// Map the delay, jitter and loss of commands that the walk tolerates
    Robustness(robustness::RobustnessArgs),
    /// Run a scene with every combination of values of its keys, and find the values at which the robot begins to fall
    Sweep(sweep::SweepArgs),
    /// Measure latency and jitter of the link between the processes, relative to the limits of this machine
    Latency(latency::LatencyArgs),
    /// The second process of `latency`
    #[command(hide = true)]
    LatencyPeer(latency::PeerArgs),
    /// Print the size of a scene's model, the size of the smallest equivalent model, and the ratio of their computing times
    Model(SceneArgs),
    /// Solve a contact problem that ended a run, with each contact law
    Contact(contact::ContactArgs),
    /// Start the plant of a session
    Plant(roles::PlantArgs),
    /// Start the controller of a session
    Controller(roles::RoleArgs),
    /// Make a controller, plant, scene or robot of your own to begin from
    #[command(subcommand)]
    New(scaffold::NewArgs),
    /// Print what a controller needs to attach to a running session
    Session(environment::EnvironmentArgs),
    #[command(flatten)]
    Control(control::ControlCommand),
    /// Show a running session or a recording in 3-D in a browser; a session can be controlled there
    View(view::ViewArgs),
    /// Show the state of a running session in the terminal
    Top(top::TopArgs),
    /// Check your own controller or plant against the rules of the wire format
    Conform(conform::ConformArgs),
    /// Inject faults into running processes, and check that nothing hangs, reports wrong results, or leaves files or processes behind
    Faults(faults::FaultsArgs),
    /// Walk for a long time, and monitor memory, open files, shared memory and latency
    Soak(soak::SoakArgs),
    /// Check this machine, and list running sessions and the files of dead ones
    Doctor,
    /// Remove the files of dead sessions from shared memory
    Clean,
    /// Connect a session to another machine
    Tunnel(tunnel::TunnelArgs),
    /// Print the message format, for controllers and plants in other languages
    Wire(wire::WireArgs),
    /// Print the robot of a scene as URDF, MJCF or TOML
    Export(export::ExportArgs),
    /// Run a foreign program that ends with the parent of this process
    #[command(hide = true)]
    Become(children::BecomeArgs),
    /// Print the contents of a recording
    Info(recording::info::InfoArgs),
    /// Convert a recording to tables
    Convert(recording::convert::ConvertArgs),
    /// Feed recorded sensors to a controller, or recorded torques to a plant, and compare the results
    Replay(recording::replay::ReplayArgs),
    /// List the built-in scenes
    List {
        /// List every key of a scene: type, default, meaning
        #[arg(long)]
        keys: bool,
        /// List the hash of all states of every scene
        #[arg(long, conflicts_with = "keys")]
        hashes: bool,
    },
}

fn main() -> ExitCode {
    // With this signal blocked, a file that exceeds `ulimit -f` causes a write error, as a full disk does.
    let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
    if let Err(failure) = resource_limits::check_stack() {
        return ended(failure);
    }
    let stop = Arc::new(AtomicBool::new(false));
    let stop_handle = stop.clone();
    if let Err(error) = ctrlc::set_handler(move || interrupt::requested(&stop_handle)) {
        log(format_args!(
            "the handler of Ctrl-C cannot be installed; Ctrl-C will end the program without a summary: {error}"
        ));
    }
    let matches = arguments::matches(help::grouped::<Cli>());
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    dispatch(cli, &stop).map_or_else(ended, |()| Exit::Ok.into())
}

/// Reports a failure, and gives its exit code.
fn ended(failure: Failure) -> ExitCode {
    let saved = failure.unsolved.map_or(String::new(), |problem| problem.save());
    if !failure.message.is_empty() {
        log(format_args!("error: {}{saved}", shortened(&failure.message)));
    }
    failure.exit.into()
}

/// Runs the command.
fn dispatch(Cli { command, quiet, .. }: Cli, stop: &Arc<AtomicBool>) -> Result<(), Failure> {
    resource_limits::check()?;
    let at_the_end = |failure: Failure| failure.keeping("nothing is kept, because the results are written at the end");
    match command {
        Some(CliCommand::Run(args)) => run::run(&args, stop),
        Some(CliCommand::Study(args)) => study::run(&args, stop).map_err(at_the_end),
        Some(CliCommand::Chart(args)) => chart::run(&args, stop).map_err(at_the_end),
        Some(CliCommand::Robustness(args)) => robustness::run(&args, stop),
        Some(CliCommand::Sweep(args)) => sweep::run(&args, stop),
        Some(CliCommand::Latency(args)) => latency::run(&args, stop).map_err(at_the_end),
        Some(CliCommand::LatencyPeer(args)) => latency::peer(&args, stop),
        Some(CliCommand::Model(args)) => model::run(&args),
        Some(CliCommand::Contact(args)) => contact::run(&args),
        Some(CliCommand::Plant(args)) => roles::plant(&args, stop),
        Some(CliCommand::Controller(args)) => roles::controller(&args, stop),
        Some(CliCommand::New(args)) => scaffold::run(&args, chart::peer_files),
        Some(CliCommand::Session(args)) => environment::run(&args, stop),
        Some(CliCommand::Control(command)) => control::run(command, stop),
        Some(CliCommand::View(args)) => view::run(&args, stop),
        Some(CliCommand::Top(args)) => top::run(&args, stop),
        Some(CliCommand::Conform(args)) => conform::run(&args, stop),
        Some(CliCommand::Faults(args)) => faults::run(&args, stop),
        Some(CliCommand::Soak(args)) => soak::run(&args, stop),
        Some(CliCommand::Doctor) => doctor::doctor(),
        Some(CliCommand::Clean) => doctor::clean(),
        Some(CliCommand::Wire(args)) => {
            wire::run(&args);
            Ok(())
        }
        Some(CliCommand::Tunnel(args)) => tunnel::run(&args, stop),
        Some(CliCommand::Become(args)) => children::exec_foreign(&args),
        Some(CliCommand::Export(args)) => export::run(&args),
        Some(CliCommand::Info(args)) => recording::info::run(&args, stop),
        Some(CliCommand::Convert(args)) => recording::convert::run(&args, stop).map_err(at_the_end),
        Some(CliCommand::Replay(args)) => recording::replay::run(&args, stop).map_err(at_the_end),
        Some(CliCommand::List { hashes: true, .. }) => hashes::print(stop),
        Some(CliCommand::List { keys: false, .. }) => list::scenes(),
        Some(CliCommand::List { keys: true, .. }) => list::keys(),
        None => run::run(&run::RunArgs::default_run(quiet), stop),
    }
}
