//! What a program that takes part in a session finds in its environment: written by whoever starts it, read by whoever is
//! started. docs/WIRE.md lists the variables.

use crate::error::PortError;
use crate::port::Contract;
use crate::scene::Scene;
use crate::session::Session;
use crate::wire::SCHEMA_HASH;
use std::env;
use std::time::Duration;

/// Where the session is, and what is to be done in it.
#[derive(Clone, Debug)]
pub struct PeerEnvironment {
    /// The session.
    pub session: Session,
    /// What its topics carry.
    pub contract: Contract,
    /// How long to wait for the other side.
    pub patience: Duration,
    /// The whole scene.
    pub scene: Scene,
    /// Whether somebody is in the place, which will be free in time.
    pub takes_over: bool,
}

/// Why the environment invites nobody.
#[derive(Debug, thiserror::Error)]
pub enum PeerEnvironmentError {
    /// A variable is missing or cannot be read.
    #[error("{0}")]
    Malformed(String),
    /// The session's name is none, or it speaks another wire schema.
    #[error(transparent)]
    Port(#[from] PortError),
}

impl PeerEnvironment {
    /// As environment variables.
    pub fn environment(&self) -> Vec<(&'static str, String)> {
        let mut environment = self.contract.environment(&self.session);
        environment.push(("BIPED_PATIENCE", self.patience.as_secs_f64().to_string()));
        // numbers and names: nothing in a scene is without a form in JSON
        environment.push(("BIPED_SCENE", serde_json::to_string(&self.scene).unwrap_or_default()));
        environment.extend(self.takes_over.then(|| ("BIPED_SUCCEEDS", "1".into())));
        environment
    }

    /// The one in this process's environment.
    ///
    /// # Errors
    /// See [`PeerEnvironmentError`].
    pub fn from_env() -> Result<PeerEnvironment, PeerEnvironmentError> {
        let session = Session::named(&variable("SESSION")?)?;
        let contract = variable("CONTRACT")?;
        let contract = Contract::parse(&contract)
            .ok_or_else(|| malformed(format!("BIPED_CONTRACT has not the lines of docs/WIRE.md: {contract:?}")))?;
        if contract.schema != SCHEMA_HASH {
            let [theirs, ours] = [contract.schema, SCHEMA_HASH].map(|hash| format!("{hash:016x}"));
            let session = session.name().into();
            return Err(PortError::Incompatible { session, what: "wire schema", theirs, ours }.into());
        }
        let patience = variable("PATIENCE")?;
        let patience = patience.parse().ok().and_then(|seconds| Duration::try_from_secs_f64(seconds).ok());
        let patience = patience.ok_or_else(|| malformed("BIPED_PATIENCE is no number of seconds"))?;
        let scene = serde_json::from_str(&variable("SCENE")?)
            .map_err(|error| malformed(format!("BIPED_SCENE is no scene: {error}")))?;
        Ok(PeerEnvironment { session, contract, patience, scene, takes_over: env::var_os("BIPED_SUCCEEDS").is_some() })
    }
}

fn malformed(sentence: impl ToString) -> PeerEnvironmentError {
    PeerEnvironmentError::Malformed(sentence.to_string())
}

fn variable(name: &str) -> Result<String, PeerEnvironmentError> {
    env::var(format!("BIPED_{name}")).map_err(|_| {
        malformed(format!(
            "BIPED_{name} is not set: start this by biped run SCENE --controller COMMAND, or --plant COMMAND"
        ))
    })
}
