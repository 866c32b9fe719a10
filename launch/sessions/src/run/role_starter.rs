//! Starts the processes of a run: plant, controller, and the successors of a controller. Each may be a foreign program.

use super::args::RunArgs;
use crate::children::{self, RoleProcess};
use indicatif::ProgressBar;
use messages::peer_environment::PeerEnvironment;
use messages::session::Session;
use shared::args::settings_with_robot;
use shared::exit::Failure;
use std::process::Stdio;

/// Role of a process, as its index among the processes of a run.
pub const PLANT: usize = 0;
/// See [`PLANT`].
pub const CONTROLLER: usize = 1;

/// Starts the processes of a run.
pub struct RoleStarter<'a> {
    pub args: &'a RunArgs,
    /// The environment of all processes except successors.
    pub environment: &'a PeerEnvironment,
    /// Lines of the processes are printed above this bar.
    pub bar: &'a ProgressBar,
}

impl RoleStarter<'_> {
    /// Starts the program of a role: a foreign one if the arguments name it, otherwise this program.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start(&self, role: usize) -> Result<RoleProcess, Failure> {
        match [&self.args.plant, &self.args.controller][role] {
            Some(command) => self.start_foreign(role, command, self.environment),
            None => self.start_own(role, Stdio::null()),
        }
    }

    /// Starts this program as the plant, which waits for its release. `None` if the plant is a foreign program, which cannot be held.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_held_plant(&self) -> Result<Option<RoleProcess>, Failure> {
        self.args.plant.is_none().then(|| self.start_own(PLANT, Stdio::piped())).transpose()
    }

    /// Starts a controller that takes over from the running one.
    ///
    /// # Errors
    /// If the system cannot start it.
    pub fn start_successor(&self, command: &str) -> Result<RoleProcess, Failure> {
        let environment = PeerEnvironment { takes_over: true, ..self.environment.clone() };
        self.start_foreign(CONTROLLER, command, &environment)
    }

    fn start_own(&self, role: usize, input: Stdio) -> Result<RoleProcess, Failure> {
        let arguments = child_arguments(self.args, &self.environment.session);
        let arguments = [arguments, self.args.system.for_child(role).arguments()].concat();
        RoleProcess::start(name(role), &arguments, &self.environment.variables(), input, self.bar)
    }

    fn start_foreign(&self, role: usize, command: &str, environment: &PeerEnvironment) -> Result<RoleProcess, Failure> {
        let variables = children::environment_variables(environment)?;
        RoleProcess::start_foreign(name(role), command, &variables, self.bar)
    }
}

fn name(role: usize) -> &'static str {
    ["plant", "controller"][role]
}

fn child_arguments(args: &RunArgs, session: &Session) -> Vec<String> {
    let settings = settings_with_robot(&args.scene.robot, &args.scene.settings);
    let settings = settings.into_iter().flat_map(|setting| ["--set".to_string(), setting]);
    let mut arguments = vec![args.scene.scene.clone(), "--session".into(), session.name().into()];
    arguments.extend(["--patience".into(), args.pace.patience.to_string()]);
    if args.pace.realtime {
        arguments.extend(["--realtime".into(), "--speed".into(), args.pace.speed.to_string()]);
    }
    arguments.extend(settings);
    arguments
}
