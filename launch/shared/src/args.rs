//! Arguments that several commands take: a scene, the pace of a run, a running session.

use crate::exit::{Exit, Failure};
use crate::list::SCENES;
use clap::Args;
use messages::load::load;
use messages::port::Pace;
use messages::scene::Scene;
use messages::session::Session;
use std::time::Duration;

/// Which scene, and what is different in it.
#[derive(Args, Clone)]
pub struct SceneArgs {
    /// Built-in scene (see `biped list`) or path of a TOML file
    pub scene: String,
    /// Put the robot of this TOML or URDF file into the scene, which is fitted to it; `biped export toml` prints one to edit
    #[arg(long, value_name = "FILE")]
    pub robot: Option<String>,
    /// Replace a value of the scene, for example plant.friction=0.3 (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
}

impl SceneArgs {
    /// Loads the scene, with the robot and the values that are given.
    ///
    /// # Errors
    /// A scene that is not there or is refused.
    pub fn load(&self) -> Result<Scene, Failure> {
        Ok(load(&self.scene, &fitted(&self.robot, &self.settings), SCENES)?)
    }
}

/// The settings of a scene, its robot before all others.
pub fn fitted(robot: &Option<String>, settings: &[String]) -> Vec<String> {
    robot.iter().map(|path| format!("robot={path}")).chain(settings.iter().cloned()).collect()
}

/// How the two processes speak.
#[derive(Args, Clone, Copy)]
pub struct PaceArgs {
    /// Run at the pace of the clock instead of as fast as possible
    #[arg(long)]
    pub realtime: bool,
    /// Simulated time per real time
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = factor, requires = "realtime")]
    pub speed: f64,
    /// Give up when the other process has not been heard of for this long [s]
    #[arg(long, default_value_t = 10.0, value_name = "SECONDS", value_parser = seconds)]
    pub patience: f64,
}

impl PaceArgs {
    /// Lockstep, or the clock.
    pub fn pace(self) -> Pace {
        if self.realtime { Pace::RealTime } else { Pace::Lockstep }
    }

    /// How long the other process may be silent.
    pub fn patience(self) -> Duration {
        Duration::from_secs_f64(self.patience)
    }
}

fn factor(text: &str) -> Result<f64, String> {
    let good = text.parse().ok().filter(|factor| (0.001..=100.0).contains(factor));
    good.ok_or_else(|| "a factor from 0.001 to 100 is needed".into())
}

/// Reads a number of seconds.
///
/// # Errors
/// Anything else.
pub fn seconds(text: &str) -> Result<f64, String> {
    let good = text.parse().ok().filter(|seconds| (0.1..=1e6).contains(seconds));
    good.ok_or_else(|| "a number of seconds from 0.1 to 1000000 is needed".into())
}

/// Which session.
#[derive(Args, Clone)]
pub struct SessionArgs {
    /// Name of the session; without it, the one that is running under a name
    #[arg(long)]
    session: Option<String>,
}

impl SessionArgs {
    /// The session to look at: the one named, or the only one that is running.
    ///
    /// # Errors
    /// If there is none, or more than one to choose from.
    pub fn find(&self) -> Result<Session, Failure> {
        self.named().unwrap_or_else(|| only(Session::running()))
    }

    /// The session to speak to: the one named, or the only one that somebody named. A run without a name is to be left alone, as
    /// others count on its bits.
    ///
    /// # Errors
    /// As [`SessionArgs::find`].
    pub fn find_named(&self) -> Result<Session, Failure> {
        self.named().unwrap_or_else(|| only_named(Session::running()))
    }

    fn named(&self) -> Option<Result<Session, Failure>> {
        self.session.as_ref().map(|name| Ok(Session::named(name)?))
    }
}

/// The only session that somebody named.
///
/// # Errors
/// If there is none, or more than one to choose from.
pub fn only_named(running: Vec<Session>) -> Result<Session, Failure> {
    let (named, unnamed): (Vec<_>, Vec<_>) = running.into_iter().partition(Session::is_named);
    match unnamed.first() {
        Some(run) if named.is_empty() => Err(Failure::new(
            Exit::Usage,
            format!(
                "the run {0} has no name, and is left alone: speak to it by --session {0}, or start it with --session NAME",
                run.name()
            ),
        )),
        _ => only(named),
    }
}

fn only(mut running: Vec<Session>) -> Result<Session, Failure> {
    match running.len() {
        1 => Ok(running.remove(0)),
        0 => Err(Failure::new(
            Exit::PeerMissing,
            "no session is running: start one with `biped run walk --realtime --session lab`",
        )),
        _ => {
            let names: Vec<&str> = running.iter().map(Session::name).collect();
            let which = format!("{} sessions are running: choose one by --session {}", names.len(), names.join(" | "));
            Err(Failure::new(Exit::Usage, which))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_that_nobody_named_is_not_spoken_to_by_chance() {
        let named = |name| Session::named(name).unwrap();
        let words =
            |running: Vec<Session>| only_named(running).map(|one| one.name().to_string()).map_err(|e| e.message);
        let run = Session::unique();
        assert!(words(vec![run.clone()]).unwrap_err().contains(&format!("speak to it by --session {}", run.name())));
        assert_eq!(words(vec![run.clone(), named("lab")]), Ok("lab".into()));
        assert!(words(vec![named("lab"), named("hall")]).unwrap_err().contains("lab | hall"));
        assert!(words(vec![]).unwrap_err().contains("no session is running"));
        assert_eq!(only(vec![run.clone()]).unwrap(), run, "to look on, it is found");
    }
}
