//! The environment variables by which a launcher tells a plant or controller which session to join. docs/WIRE.md lists them.

use crate::clock::Timeout;
use crate::error::PortError;
use crate::load::text;
use crate::port::Contract;
use crate::scene::Scene;
use crate::session::Session;
use crate::wire::SCHEMA_HASH;
use std::collections::BTreeMap;
use std::env;
use std::time::Duration;

/// Name of the variable that is set if a process replaces another one.
pub const SUCCEEDS: &str = "BIPED_SUCCEEDS";
/// Name of the variable that has the contract. It is set for children of a launcher.
const CONTRACT: &str = "BIPED_CONTRACT";
/// Time to wait for a session, unless the environment says otherwise.
const PATIENCE: Duration = Duration::from_secs(10);
/// Interval at which a session that does not exist yet is checked for.
const POLL: Duration = Duration::from_millis(5);

/// The session that a process joins, and its task there.
#[derive(Clone, Debug)]
pub struct PeerEnvironment {
    /// The session.
    pub session: Session,
    /// Contract of the session.
    pub contract: Contract,
    /// How long to wait for the other side.
    pub patience: Duration,
    /// The scene.
    pub scene: Scene,
    /// Whether the process replaces another one, for whose end it has to wait.
    pub takes_over: bool,
}

/// Why the environment does not describe a session.
#[derive(Debug, thiserror::Error)]
pub enum PeerEnvironmentError {
    /// A variable is missing or cannot be parsed.
    #[error("{0}")]
    Malformed(String),
    /// The name of the session is not allowed, or its wire schema differs.
    #[error(transparent)]
    Port(#[from] PortError),
}

impl PeerEnvironment {
    /// The environment variables.
    pub fn variables(&self) -> Vec<(&'static str, String)> {
        let mut variables = self.contract.variables(&self.session);
        variables.push(("BIPED_PATIENCE", self.patience.as_secs_f64().to_string()));
        // A scene holds numbers and names only, so writing it as JSON cannot fail.
        variables.push(("BIPED_SCENE", serde_json::to_string(&self.scene).unwrap_or_default()));
        variables.extend(self.takes_over.then(|| (SUCCEEDS, "1".into())));
        variables
    }

    /// Writes this environment into the session, for programs that are started by hand, and the scene, for observers.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no room for it.
    pub fn publish(&self) -> Result<(), PortError> {
        let variables: BTreeMap<_, _> = self.variables().into_iter().collect();
        self.session.publish_scene(&text(&self.scene))?;
        self.session.publish_environment(&serde_json::to_string(&variables).unwrap_or_default())
    }

    /// Whether the launcher of this process has given it a session and a scene.
    pub fn is_given() -> bool {
        env::var_os(CONTRACT).is_some()
    }

    /// The peer environment from this process's environment variables. If only `BIPED_SESSION` is set, this function attaches to
    /// that session.
    ///
    /// # Errors
    /// See [`PeerEnvironmentError`].
    pub fn from_env(keeps_waiting: impl Fn() -> bool) -> Result<PeerEnvironment, PeerEnvironmentError> {
        let variable = |name: &str| env::var(name).ok();
        match (variable("BIPED_SESSION"), variable(CONTRACT)) {
            (Some(session), None) => {
                let patience = variable("BIPED_PATIENCE").map_or(Ok(PATIENCE), |seconds| patience(&seconds))?;
                PeerEnvironment::attach(&session, patience, keeps_waiting)
            }
            _ => PeerEnvironment::parse(variable),
        }
    }

    /// Takes part in a session by its name, with this patience. Waits as [`PeerEnvironment::published`].
    ///
    /// # Errors
    /// As [`PeerEnvironment::published`].
    pub fn attach(
        name: &str,
        patience: Duration,
        keeps_waiting: impl Fn() -> bool,
    ) -> Result<PeerEnvironment, PeerEnvironmentError> {
        Ok(PeerEnvironment { patience, ..PeerEnvironment::published(name, patience, keeps_waiting)? })
    }

    /// What the plant of a session has published. Waits for the plant, at most for `limit`, and reports the wait each second on standard
    /// error.
    ///
    /// # Errors
    /// No session of that name within that time, or another [`PeerEnvironmentError`].
    pub fn published(
        name: &str,
        limit: Duration,
        keeps_waiting: impl Fn() -> bool,
    ) -> Result<PeerEnvironment, PeerEnvironmentError> {
        let (session, mut waiting) = (Session::named(name)?, Timeout::new("session", limit));
        let published = || session.is_running().then(|| session.environment()).flatten();
        loop {
            if let Some(json) = published() {
                let variables: BTreeMap<String, String> = serde_json::from_str(&json)
                    .map_err(|error| malformed(format!("session `{name}` has published no environment: {error}")))?;
                return PeerEnvironment::parse(|key| variables.get(key).cloned());
            }
            if waiting.has_expired() || !keeps_waiting() {
                return Err(PortError::NoSession { session: name.into(), why: session.absence() }.into());
            }
            std::thread::sleep(POLL);
        }
    }

    fn parse(variable: impl Fn(&str) -> Option<String>) -> Result<PeerEnvironment, PeerEnvironmentError> {
        let needed = |name: &str| {
            variable(name).ok_or_else(|| {
                malformed(format!(
                    "{name} is not set: set BIPED_SESSION to the name of a running session, \
                     or start this program by biped run SCENE --controller COMMAND, or --plant COMMAND"
                ))
            })
        };
        let session = Session::named(&needed("BIPED_SESSION")?)?;
        let contract = needed(CONTRACT)?;
        let contract = Contract::parse(&contract).ok_or_else(|| {
            malformed(format!("BIPED_CONTRACT does not have the lines that docs/WIRE.md lists: {contract:?}"))
        })?;
        if contract.schema != SCHEMA_HASH {
            let [theirs, ours] = [contract.schema, SCHEMA_HASH].map(|hash| format!("{hash:016x}"));
            let session = session.name().into();
            return Err(PortError::Incompatible { session, what: "wire schema", theirs, ours }.into());
        }
        let patience = patience(&needed("BIPED_PATIENCE")?)?;
        let scene = serde_json::from_str(&needed("BIPED_SCENE")?)
            .map_err(|error| malformed(format!("BIPED_SCENE is not a scene: {error}")))?;
        Ok(PeerEnvironment { session, contract, patience, scene, takes_over: variable(SUCCEEDS).is_some() })
    }
}

fn malformed(sentence: impl ToString) -> PeerEnvironmentError {
    PeerEnvironmentError::Malformed(sentence.to_string())
}

fn patience(seconds: &str) -> Result<Duration, PeerEnvironmentError> {
    let patience = seconds.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
    patience.ok_or_else(|| malformed("BIPED_PATIENCE is not a number of seconds"))
}
