//! `biped`: one program, three roles. It starts plant and controller as processes of their own and watches over them;
//! as `biped plant` and `biped controller` it is either of them.
//!
//! | crate | what it has |
//! |---|---|
//! | [`shared`] | what all commands use: arguments, built-in scenes, exit codes, output, progress |
//! | [`records`] | what a run leaves, and how people look at it: figures, report, recordings, pages |
//! | [`sessions`] | plant and controller as processes: started, watched, asked, swapped, ended |
//! | [`laboratory`] | measurements: accuracy, speed, latency, robustness, faults, conformance |

#![cfg_attr(fuzzing, no_main, allow(dead_code, reason = "the fuzzer begins elsewhere"))]

#[cfg(fuzzing)]
mod fuzz;
mod help;

use clap::{FromArgMatches, Parser, Subcommand};
use laboratory::{chart, conform, contact, faults, hashes, latency, robustness, soak, study};
use nix::sys::signal::{SigSet, Signal};
use records::{recording, top, view};
use sessions::{allowance, children, desk, doctor, environment, export, model, roles, run, scaffold, tunnel, wire};
use shared::args::SceneArgs;
use shared::exit::{self, Exit, Failure};
use shared::list;
use shared::output::{brief, tell};
use std::process::ExitCode;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Simulates and controls an eight-axis biped robot: plant and controller are two processes. Without a command: `run walk --out out/walk`.
#[derive(Parser)]
#[command(version, after_help = exit::HELP)]
struct Cli {
    #[command(subcommand)]
    command: Option<Command>,
    /// Keep the model that the scene names, as every run without --smallest does
    #[arg(long, global = true, hide = true)]
    full: bool,
    /// Show no progress
    #[arg(long, global = true)]
    quiet: bool,
}

#[derive(Subcommand)]
enum Command {
    /// Run a scene: start both processes, show progress, print a summary
    Run(run::RunArgs),
    /// Run a table of cases in parallel, and print it
    Study(study::StudyArgs),
    /// Chart speed against accuracy of contact laws, integration methods and model sizes, also beside other engines
    Chart(chart::ChartArgs),
    /// Map the delay, jitter and loss of commands that the walk survives
    Robustness(robustness::RobustnessArgs),
    /// Measure latency and jitter of the link between the processes, beside the limits of this machine
    Latency(latency::LatencyArgs),
    /// The second process of `latency`
    #[command(hide = true)]
    LatencyPeer(latency::PeerArgs),
    /// Print the size of a scene's model, the smallest model with the same answer, and its cost
    Model(SceneArgs),
    /// Solve the contact problem that ended a run, by every law
    Contact(contact::ContactArgs),
    /// Start the plant of a session
    Plant(roles::RoleArgs),
    /// Start the controller of a session
    Controller(roles::RoleArgs),
    /// Make a controller, scene or robot of your own to begin from
    #[command(subcommand)]
    New(scaffold::NewArgs),
    /// Print what a controller needs to attach to a running session
    Session(environment::EnvironmentArgs),
    #[command(flatten)]
    Desk(desk::Wish),
    /// Show a running session or a recording in a browser, in 3-D; a session can be pushed and led from there
    View(view::ViewArgs),
    /// Show the state of a running session in the terminal
    Top(top::TopArgs),
    /// Check a controller or plant of yours against the rules of the wire
    Conform(conform::ConformArgs),
    /// Injure real processes in many ways, and check that nothing hangs, lies or is left behind
    Faults(faults::FaultsArgs),
    /// Walk for a long time, and watch memory, open files, shared memory and latency
    Soak(soak::SoakArgs),
    /// Check this machine; list running sessions, and what dead ones have left
    Doctor,
    /// Remove what dead sessions have left in shared memory
    Clean,
    /// Connect a session with another machine
    Tunnel(tunnel::TunnelArgs),
    /// Print the message format, for controllers and plants in other languages
    Wire(wire::WireArgs),
    /// Print the robot of a scene as URDF, MJCF or TOML
    Export(export::ExportArgs),
    /// Become another program
    #[command(hide = true)]
    Become(children::BecomeArgs),
    /// Print what a recording contains
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
    // A file that reaches the limit of `ulimit -f` gives an error, as a full disk does, and no signal.
    let _ = SigSet::from(Signal::SIGXFSZ).thread_block();
    let stop = Arc::new(AtomicBool::new(false));
    let asked = stop.clone();
    if let Err(error) = ctrlc::set_handler(move || asked.store(true, Relaxed)) {
        tell(format_args!("Ctrl-C will not end this in order: {error}"));
    }
    let matches = help::grouped::<Cli>().get_matches();
    let cli = Cli::from_arg_matches(&matches).unwrap_or_else(|error| error.exit());
    match obey(cli, &stop) {
        Ok(()) => Exit::Ok.into(),
        Err(failure) => {
            let case = failure.case.map_or(String::new(), |case| case.keep());
            tell(format_args!("error: {}{case}", brief(&failure.message)));
            failure.exit.into()
        }
    }
}

/// Dispatches the command.
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
        Some(Command::New(args)) => scaffold::run(&args),
        Some(Command::Session(args)) => environment::run(&args, stop),
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
        Some(Command::Convert(args)) => recording::convert::run(&args, stop),
        Some(Command::Replay(args)) => recording::replay::run(&args, stop),
        Some(Command::List { hashes: true, .. }) => hashes::print(),
        Some(Command::List { keys: false, .. }) => list::scenes(),
        Some(Command::List { keys: true, .. }) => list::keys(),
        None => run::run(&run::RunArgs::main_job(quiet), stop),
    }
}
