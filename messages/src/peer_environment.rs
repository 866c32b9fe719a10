//! The environment variables by which a launcher tells a plant or controller which session to join. docs/WIRE.md lists them.

use crate::error::PortError;
use crate::port::Contract;
use crate::scene::Scene;
use crate::session::Session;
use crate::wire::SCHEMA_HASH;
use std::env;
use std::time::Duration;

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
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        let mut environment = self.contract.environment(&self.session);
        environment.push(("BIPED_PATIENCE", self.patience.as_secs_f64().to_string()));
        // A scene holds numbers and names only, so writing it as JSON cannot fail.
        environment.push(("BIPED_SCENE", serde_json::to_string(&self.scene).unwrap_or_default()));
        environment.extend(self.takes_over.then(|| ("BIPED_SUCCEEDS", "1".into())));
        environment
    }

    /// Reads the environment of this process.
    ///
    /// # Errors
    /// See [`PeerEnvironmentError`].
    pub fn from_env() -> Result<PeerEnvironment, PeerEnvironmentError> {
        let session = Session::named(&variable("SESSION")?)?;
        let contract = variable("CONTRACT")?;
        let contract = Contract::parse(&contract).ok_or_else(|| {
            malformed(format!("BIPED_CONTRACT does not have the lines that docs/WIRE.md lists: {contract:?}"))
        })?;
        if contract.schema != SCHEMA_HASH {
            let [theirs, ours] = [contract.schema, SCHEMA_HASH].map(|hash| format!("{hash:016x}"));
            let session = session.name().into();
            return Err(PortError::Incompatible { session, what: "wire schema", theirs, ours }.into());
        }
        let patience = variable("PATIENCE")?;
        let patience = patience.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let patience = patience.ok_or_else(|| malformed("BIPED_PATIENCE is not a number of seconds"))?;
        let scene = serde_json::from_str(&variable("SCENE")?)
            .map_err(|error| malformed(format!("BIPED_SCENE is not a scene: {error}")))?;
        Ok(PeerEnvironment { session, contract, patience, scene, takes_over: env::var_os("BIPED_SUCCEEDS").is_some() })
    }
}

fn malformed(sentence: impl ToString) -> PeerEnvironmentError {
    PeerEnvironmentError::Malformed(sentence.to_string())
}

fn variable(name: &str) -> Result<String, PeerEnvironmentError> {
    env::var(format!("BIPED_{name}")).map_err(|_| {
        malformed(format!(
            "BIPED_{name} is not set: start this program by biped run SCENE --controller COMMAND, or --plant COMMAND"
        ))
    })
}
