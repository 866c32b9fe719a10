//! Command-line arguments that several commands share: scene, pace, session.

use crate::exit::{Exit, Failure};
use crate::list::SCENES;
use clap::Args;
use clap::builder::NonEmptyStringValueParser;
use messages::load::load;
use messages::port::Pace;
use messages::scene::Scene;
use messages::session::{Session, SharedSession};
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::time::Duration;

/// A scene and the changes to it.
#[derive(Args, Clone)]
pub struct SceneArgs {
    /// Built-in scene (see `biped list`) or path of a TOML file
    pub scene: String,
    /// Use the robot of this TOML or URDF file; the scene is scaled to it. `biped export toml` prints one to edit
    #[arg(long, value_name = "FILE", value_parser = NonEmptyStringValueParser::new())]
    pub robot: Option<String>,
    /// Replace a value of the scene, for example plant.friction=0.3 (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    pub settings: Vec<String>,
}

impl SceneArgs {
    /// Loads the scene with its robot and its changed values.
    ///
    /// # Errors
    /// If the scene is missing or invalid.
    pub fn load(&self) -> Result<Scene, Failure> {
        Ok(load(&self.scene, &settings_with_robot(&self.robot, &self.settings), SCENES)?)
    }
}

/// The settings of a scene, with the robot as the first one: later settings can change it.
pub fn settings_with_robot(robot: &Option<String>, settings: &[String]) -> Vec<String> {
    robot.iter().map(|path| format!("robot={path}")).chain(settings.iter().cloned()).collect()
}

/// Default of `--patience` [s]. Starting both processes takes less than a second; a loaded machine needs a margin.
pub const DEFAULT_PATIENCE: f64 = 10.0;

/// The pace of a run, and how long each process waits for the other.
#[derive(Args, Clone, Copy)]
pub struct PaceArgs {
    /// Run in real time instead of as fast as possible
    #[arg(long)]
    pub realtime: bool,
    /// Simulated time per real time, with --realtime
    #[arg(long, default_value_t = 1.0, value_name = "FACTOR", value_parser = parse_speed, requires = "realtime")]
    pub speed: f64,
    /// Time without a message from the other process after which this one gives up [s]
    #[arg(long, default_value_t = DEFAULT_PATIENCE, value_name = "SECONDS", value_parser = parse_seconds)]
    pub patience: f64,
}

impl PaceArgs {
    /// Lockstep or real time.
    pub fn pace(self) -> Pace {
        if self.realtime { Pace::RealTime } else { Pace::Lockstep }
    }

    /// Longest time without a message from the other process.
    pub fn patience(self) -> Duration {
        Duration::from_secs_f64(self.patience)
    }
}

/// Range of `--speed` [-].
const SPEED_RANGE: RangeInclusive<f64> = 0.001..=100.0;
/// Range of options that are a time [s].
const SECONDS_RANGE: RangeInclusive<f64> = 0.1..=1e6;

fn parse_speed(text: &str) -> Result<f64, String> {
    parse_within(text, "a factor", SPEED_RANGE)
}

/// Parses a time in seconds.
///
/// # Errors
/// If the text is no number, or out of range.
pub fn parse_seconds(text: &str) -> Result<f64, String> {
    parse_within(text, "a number of seconds", SECONDS_RANGE)
}

/// Parses a number that is not NaN or infinite.
///
/// # Errors
/// If the text is no such number.
pub fn parse_finite(text: &str) -> Result<f64, String> {
    text.parse().ok().filter(|number: &f64| number.is_finite()).ok_or_else(|| "a finite number is needed".into())
}

/// Parses a number within a range. `what` names it in the error.
///
/// # Errors
/// If the text is no number, or out of range.
pub fn parse_within(text: &str, what: &str, range: RangeInclusive<f64>) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number| range.contains(number));
    number.ok_or_else(|| format!("{what} from {} to {} is needed", range.start(), range.end()))
}

/// Parses the path of an output. Other programs write to standard output if it is `-`; here it would become a file of that name.
///
/// # Errors
/// If it is `-` or empty.
pub fn parse_output(text: &str) -> Result<PathBuf, String> {
    match text {
        "-" => Err("standard output is not supported here: name a file, or ./- for one of this name".into()),
        "" => Err("a path is needed".into()),
        path => Ok(path.into()),
    }
}

/// The session that a command works on.
#[derive(Args, Clone)]
pub struct SessionArgs {
    /// Name of the session; by default the only one that is running. A run that was started without --session has a name of its own, which requests need
    #[arg(long)]
    session: Option<String>,
}

/// A session that a command can look at or talk to.
#[derive(Clone, Debug)]
pub enum Reachable {
    /// A session of this user.
    Own(Session),
    /// A session that another user shares.
    Shared(SharedSession),
}

impl SessionArgs {
    /// The session to observe: the one with the given name, or the only one that is running.
    ///
    /// # Errors
    /// If no session is running, or several are and none is named.
    pub fn find(&self) -> Result<Session, Failure> {
        self.given().unwrap_or_else(|| single(Session::running()))
    }

    /// The session to control: the one with the given name, or the only one that the user has named. A run without a name is
    /// never chosen by default, because a request would change its results.
    ///
    /// # Errors
    /// As [`SessionArgs::find`].
    pub fn find_named(&self) -> Result<Session, Failure> {
        self.given().unwrap_or_else(|| single_named(Session::running()))
    }

    /// As [`SessionArgs::find`] or [`SessionArgs::find_named`], or a session that another user shares: `OWNER/NAME`, or a name that no
    /// session of this user has.
    ///
    /// # Errors
    /// As both, and if several users share a session of that name.
    pub fn reach(&self, own: fn(&SessionArgs) -> Result<Session, Failure>) -> Result<Reachable, Failure> {
        let given = self.session.as_deref().unwrap_or_default();
        if let Some((owner, name)) = given.split_once('/') {
            let shared = SharedSession::of(owner, name)?;
            return Ok(shared.own().cloned().map_or(Reachable::Shared(shared), Reachable::Own));
        }
        let session = own(self)?;
        if session.is_running() {
            return Ok(Reachable::Own(session));
        }
        let mut others = SharedSession::of_others(&session);
        if others.len() > 1 {
            others.retain(|other| other.connect().is_ok());
        }
        match others.len() {
            0 => Ok(Reachable::Own(session)), // which says that it is not running
            1 => Ok(Reachable::Shared(others.remove(0))),
            _ => {
                let names: Vec<_> = others.iter().map(SharedSession::name).collect();
                let which = format!("{} users share a session of that name: choose {}", names.len(), names.join(" | "));
                Err(Failure::new(Exit::Usage, which))
            }
        }
    }

    fn given(&self) -> Option<Result<Session, Failure>> {
        self.session.as_ref().map(|name| Ok(Session::named(name)?))
    }
}

/// The only session that the user has named.
///
/// # Errors
/// If there is none, or more than one.
pub fn single_named(running: Vec<Session>) -> Result<Session, Failure> {
    let (named, unnamed): (Vec<_>, Vec<_>) = running.into_iter().partition(Session::is_named);
    match unnamed.first() {
        Some(run) if named.is_empty() => Err(Failure::new(
            Exit::Usage,
            format!(
                "the run {0} has no name of its own, so requests do not go to it: choose it by --session {0}, or start it with --session NAME",
                run.name()
            ),
        )),
        _ => single(named),
    }
}

fn single(mut running: Vec<Session>) -> Result<Session, Failure> {
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
    fn requests_do_not_go_to_an_unnamed_run_by_default() {
        let named = |name| Session::named(name).unwrap();
        let chosen =
            |running: Vec<Session>| single_named(running).map(|one| one.name().to_string()).map_err(|e| e.message);
        let run = Session::unique();
        assert!(chosen(vec![run.clone()]).unwrap_err().contains(&format!("choose it by --session {}", run.name())));
        assert_eq!(chosen(vec![run.clone(), named("lab")]), Ok("lab".into()));
        assert!(chosen(vec![named("lab"), named("hall")]).unwrap_err().contains("lab | hall"));
        assert!(chosen(vec![]).unwrap_err().contains("no session is running"));
        assert_eq!(single(vec![run.clone()]).unwrap(), run, "observers find it");
    }
}
