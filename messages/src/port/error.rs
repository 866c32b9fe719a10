//! Why a link could not be made or broke.

use std::fmt::Debug;
use thiserror::Error;

/// Why a link could not be made or broke.
#[derive(Debug, Error)]
pub enum PortError {
    /// A name that cannot be part of a file name.
    #[error("`{name}` cannot name a session: use 1 to 32 letters, digits or hyphens")]
    SessionName {
        /// As given.
        name: String,
    },
    /// The other side brings another contract.
    #[error(
        "session `{session}` speaks {what} {theirs}, this process {ours}: start both with the same program, scene and options"
    )]
    Incompatible {
        /// Name of the session.
        session: String,
        /// Which part of the contract.
        what: &'static str,
        /// Value already there.
        theirs: String,
        /// Value brought.
        ours: String,
    },
    /// The topic was made by something else.
    #[error(
        "session `{session}` was made by another version of this program ({reason}): end that one, or use another --session"
    )]
    Foreign {
        /// Name of the session.
        session: String,
        /// As iceoryx2 says it.
        reason: String,
    },
    /// There may be only one.
    #[error("session `{session}` already has a {role}: end that one, or use another --session")]
    Taken {
        /// Name of the session.
        session: String,
        /// Plant or controller.
        role: &'static str,
    },
    /// Nobody has made it, or nobody is left.
    #[error("no session `{session}` is running: {}", advice(.other.as_deref()))]
    NoSession {
        /// Name of the session.
        session: String,
        /// Another user who has one of that name.
        other: Option<String>,
    },
    /// Nobody answers at a service.
    #[error("session `{session}` has no {role} that answers")]
    Absent {
        /// Name of the session.
        session: String,
        /// Plant or controller.
        role: &'static str,
    },
    /// Shared memory is missing, full or unusable.
    #[error("shared memory: {0}")]
    SharedMemory(String),
}

/// Where to look for a session.
fn advice(other: Option<&str>) -> String {
    let of_other = |user| format!("that of user {user} is theirs alone, as sessions are each user's own");
    other.map_or_else(|| "`biped doctor` lists those that are".into(), of_other)
}

/// What iceoryx2 said of a step that failed.
pub(super) fn broken(what: &str, reason: impl Debug) -> PortError {
    PortError::SharedMemory(format!("{what} failed: {reason:?}"))
}
