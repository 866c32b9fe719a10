//! `biped conform`: whether somebody else's controller or plant keeps to docs/WIRE.md, rule by rule. The program is started as
//! `biped run` would start it; we are the other side.
//!
//! | what | where |
//! |---|---|
//! | the program under test | [`guest`] |
//! | what every message must be | [`stamps`] |
//! | the other side: a robot, or its driver | [`robot`], [`driver`] |
//! | the rules of a controller, and of a plant | [`controller`], [`plant`] |
//! | whom it must refuse, and when it must give up | [`company`] |

mod company;
mod controller;
mod driver;
mod guest;
mod plant;
mod robot;
mod stamps;

pub use company::others;

use clap::Args;
use guest::Host;
use shared::args::SceneArgs;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::print_text;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
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
    #[arg(long, value_name = "COMMAND", required_unless_present = "plant", conflicts_with = "plant")]
    controller: Option<String>,
    /// Plant to check, likewise
    #[arg(long, value_name = "COMMAND")]
    plant: Option<String>,
    /// How long it may take to start or to answer [s]
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = shared::args::parse_seconds)]
    patience: f64,
}

/// What was found on a rule: a remark, or what was done instead.
type Finding = Result<String, String>;

/// Some of the rules.
type Part = fn(&Host, &mut Report) -> Result<(), String>;

/// The rules, told one by one.
struct Report<'a> {
    kept: usize,
    broken: usize,
    stop: &'a AtomicBool,
}

impl Report<'_> {
    /// Tells whether a rule, which stands in a section of docs/WIRE.md, was kept.
    fn rule(&mut self, rule: &str, section: &str, finding: Finding) -> bool {
        match &finding {
            Ok(remark) if remark.is_empty() => print_text(format_args!("ok      {rule}\n")),
            Ok(remark) => print_text(format_args!("ok      {rule} ({remark})\n")),
            Err(instead) => print_text(format_args!("FAILED  {rule}: {instead} (docs/WIRE.md, {section})\n")),
        }
        let counter = if finding.is_ok() { &mut self.kept } else { &mut self.broken };
        *counter += 1;
        finding.is_ok()
    }

    /// What is worth knowing and breaks no rule.
    fn note(&self, text: &str) {
        print_text(format_args!("note    {text}\n"));
    }

    /// Checks one part after the other, until Ctrl-C.
    fn each(&mut self, host: &Host, parts: &[Part]) -> Result<(), String> {
        for (nth, part) in parts.iter().enumerate().take_while(|_| !self.stop.load(Relaxed)) {
            part(host, self)?;
            if nth == 0 && self.kept == 0 {
                self.note("what does not begin refuses everything: what is kept below says little");
            }
        }
        Ok(())
    }
}

/// Checks every rule.
///
/// # Errors
/// [`Exit::Nonconforming`] if one is broken.
pub fn run(args: &ConformArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let scene = SceneArgs { scene: args.scene.clone(), robot: None, settings: args.settings.clone() };
    let mut report = Report { kept: 0, broken: 0, stop };
    let command = args.controller.as_ref().or(args.plant.as_ref()).cloned().unwrap_or_default();
    let host = Host { command, scene: scene.load()?, patience: Duration::from_secs_f64(args.patience) };
    if host.scene.controller.is_none() {
        return Err(Failure::new(
            Exit::Usage,
            format!("scene `{}` has no controller: nothing is said in it", args.scene),
        ));
    }
    match args.plant {
        None => controller::check(&host, &mut report),
        Some(_) => plant::check(&host, &mut report),
    }
    .map_err(|error| Failure::new(Exit::Fault, error))?;
    print_text(format_args!("\n{} rules kept, {} broken\n", report.kept, report.broken));
    check_interrupt(stop)?;
    match report.broken {
        0 => Ok(()),
        1 => Err(Failure::new(Exit::Nonconforming, "a rule of docs/WIRE.md is broken")),
        count => Err(Failure::new(Exit::Nonconforming, format!("{count} rules of docs/WIRE.md are broken"))),
    }
}
