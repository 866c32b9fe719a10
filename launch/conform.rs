//! `biped conform`: checks an external controller or plant against docs/WIRE.md, rule by rule. The program is started as `biped run` would
//! start it; `biped conform` is its peer.
//!
//! | what | where |
//! |---|---|
//! | the program under test | [`guest`] |
//! | rules for every message | [`stamps`] |
//! | the peer: a robot, or its controller | [`robot`], [`driver`] |
//! | the rules of a controller, and of a plant | [`controller`], [`plant`] |
//! | peers that it must refuse, and when it must give up | [`company`] |

mod company;
mod controller;
mod driver;
mod guest;
mod plant;
mod robot;
mod stamps;

pub use company::others;

use crate::SceneArgs;
use crate::exit::{Exit, Failure, unless};
use crate::output::say;
use clap::Args;
use guest::Host;
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
    /// Time limit for its start and its answers [s]
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = crate::seconds)]
    patience: f64,
}

/// The result of a rule: a remark, or the observed violation.
type Finding = Result<String, String>;

/// A group of rules.
type Part = fn(&Host, &mut Report) -> Result<(), String>;

/// The report: a line for each rule.
struct Report<'a> {
    kept: usize,
    broken: usize,
    stop: &'a AtomicBool,
}

impl Report<'_> {
    /// Reports whether a rule of a section of docs/WIRE.md was kept.
    fn rule(&mut self, rule: &str, section: &str, finding: Finding) -> bool {
        match &finding {
            Ok(remark) if remark.is_empty() => say(format_args!("ok      {rule}\n")),
            Ok(remark) => say(format_args!("ok      {rule} ({remark})\n")),
            Err(instead) => say(format_args!("FAILED  {rule}: {instead} (docs/WIRE.md, {section})\n")),
        }
        let counter = if finding.is_ok() { &mut self.kept } else { &mut self.broken };
        *counter += 1;
        finding.is_ok()
    }

    /// Reports an observation that breaks no rule.
    fn note(&self, text: &str) {
        say(format_args!("note    {text}\n"));
    }

    /// Checks one group after the other, until Ctrl-C.
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
            format!("scene `{}` has no controller, so its processes exchange no messages", args.scene),
        ));
    }
    match args.plant {
        None => controller::check(&host, &mut report),
        Some(_) => plant::check(&host, &mut report),
    }
    .map_err(|error| Failure::new(Exit::Fault, error))?;
    say(format_args!("\n{} rules kept, {} broken\n", report.kept, report.broken));
    unless(stop)?;
    match report.broken {
        0 => Ok(()),
        1 => Err(Failure::new(Exit::Nonconforming, "a rule of docs/WIRE.md is broken")),
        count => Err(Failure::new(Exit::Nonconforming, format!("{count} rules of docs/WIRE.md are broken"))),
    }
}
