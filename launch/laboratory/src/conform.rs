//! `biped conform`: checks an external controller or plant against docs/WIRE.md, rule by rule. The program is started as `biped run` would
//! start it; `biped conform` is its peer.
//!
//! | what | where |
//! |---|---|
//! | the program under test | [`program`] |
//! | rules for every message | [`stamps`] |
//! | the peer: a robot, or its controller | [`robot`], [`driver`] |
//! | the rules of a controller, and of a plant | [`controller`], [`plant`] |
//! | peers that it must refuse, and when it must give up | [`refusals`] |

mod controller;
mod driver;
mod plant;
mod program;
mod refusals;
mod report;
mod robot;
mod stamps;

pub use refusals::others;

use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use program::ProgramSetup;
use report::RuleReport;
use shared::args::SceneArgs;
use shared::exit::{Exit, Failure, check_interrupt_after_results};
use shared::output::print_text;
use std::sync::atomic::AtomicBool;
use std::time::Duration;

/// Arguments of `biped conform`.
#[derive(Args)]
pub struct ConformArgs {
    /// Scene to check in: built in (see `biped list`), or a TOML file
    #[arg(default_value = "stand")]
    scene: String,
    /// Replace a value of the scene; repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Controller to check, as for `biped run --controller`: a program with its arguments
    #[arg(
        long,
        value_name = "COMMAND",
        required_unless_present = "plant",
        conflicts_with = "plant",
        value_parser = NonEmptyStringValueParser::new()
    )]
    controller: Option<String>,
    /// Plant to check, as for `biped run --plant`: a program with its arguments
    #[arg(long, value_name = "COMMAND", value_parser = NonEmptyStringValueParser::new())]
    plant: Option<String>,
    /// Time limit for the start of the program and for its answers [s]
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = shared::args::parse_seconds)]
    patience: f64,
}

/// Checks every rule.
///
/// # Errors
/// [`Exit::Nonconforming`] if one is broken.
pub fn run(args: &ConformArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let scene = SceneArgs { scene: args.scene.clone(), robot: None, settings: args.settings.clone() };
    let mut report = RuleReport { kept: 0, broken: 0, stop };
    let command = args.controller.as_ref().or(args.plant.as_ref()).cloned().unwrap_or_default();
    let patience = Duration::from_secs_f64(args.patience);
    let host = ProgramSetup { command, scene: scene.load()?, patience, stop };
    if host.scene.controller.is_none() {
        return Err(Failure::new(
            Exit::Usage,
            format!("scene `{}` has no controller, so its processes exchange no messages", args.scene),
        ));
    }
    match args.plant {
        None => controller::check(&host, &mut report),
        Some(_) => plant::check(&host, &mut report),
    }
    .map_err(|error| Failure::new(Exit::Fault, error))?;
    print_text(format_args!("\n{} rules kept, {} broken\n", report.kept, report.broken));
    check_interrupt_after_results(stop)?;
    match report.broken {
        0 => Ok(()),
        1 => Err(Failure::new(Exit::Nonconforming, "a rule of docs/WIRE.md is broken")),
        count => Err(Failure::new(Exit::Nonconforming, format!("{count} rules of docs/WIRE.md are broken"))),
    }
}
