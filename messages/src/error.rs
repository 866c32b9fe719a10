//! Errors of the connection between the processes of a session.

use std::fmt::Debug;
use thiserror::Error;

/// Why a connection could not be opened, or why it failed.
#[derive(Debug, Error)]
pub enum PortError {
    /// The name of a session is not allowed.
    #[error("`{name}` cannot name a session: use 1 to 32 letters, digits or hyphens")]
    SessionName {
        /// Name as given.
        name: String,
    },
    /// The other side has another contract.
    #[error(
        "session `{session}` has {what} {theirs}, but this process has {ours}: start both with the same program, scene and options"
    )]
    Incompatible {
        /// Name of the session.
        session: String,
        /// Part of the contract that differs.
        what: &'static str,
        /// Value of the session.
        theirs: String,
        /// Value of this process.
        ours: String,
    },
    /// The topic was created by a different program.
    #[error(
        "session `{session}` was made by another version of this program ({reason}): end that one, or use another --session"
    )]
    Foreign {
        /// Name of the session.
        session: String,
        /// Reason as iceoryx2 reports it.
        reason: String,
    },
    /// The session already has a process of this role, and only one is allowed.
    #[error("session `{session}` already has a {role}: end that one, or use another --session")]
    Taken {
        /// Name of the session.
        session: String,
        /// Plant or controller.
        role: &'static str,
    },
    /// The session has no room for one more reader.
    #[error("session `{session}` has as many observers as it allows: end a `biped view`, a `biped top` or a recorder")]
    Crowded {
        /// Name of the session.
        session: String,
    },
    /// No process is in the session.
    #[error("no session `{session}` is running: {}", advice(.other.as_deref()))]
    NoSession {
        /// Name of the session.
        session: String,
        /// Another user who has a session of that name.
        other: Option<String>,
    },
    /// The control service does not answer.
    #[error("session `{session}` has no {role} that answers")]
    Absent {
        /// Name of the session.
        session: String,
        /// Plant or controller.
        role: &'static str,
    },
    /// A session cannot be shared, or is not shared with this user.
    #[error("{0}")]
    Share(String),
    /// Shared memory is missing, full or unusable.
    #[error("shared memory: {0}")]
    SharedMemory(String),
}

impl PortError {
    /// The exit code with which a process ends that cannot go on: docs/WIRE.md lists them.
    pub fn exit_code(&self) -> u8 {
        match self {
            PortError::SessionName { .. } | PortError::Share(_) => 2,
            PortError::NoSession { .. } | PortError::Absent { .. } => 3,
            PortError::Incompatible { .. }
            | PortError::Foreign { .. }
            | PortError::Taken { .. }
            | PortError::Crowded { .. } => 5,
            PortError::SharedMemory(_) => 6,
        }
    }

    /// An operation of iceoryx2 failed for this reason.
    pub(crate) fn failed(what: &str, reason: impl Debug) -> PortError {
        PortError::SharedMemory(format!("{what} failed: {reason:?}"))
    }
}

/// How to find the right session.
fn advice(other: Option<&str>) -> String {
    let of_other = |user| format!("the session of that name belongs to user {user}; ask them for --share GROUP");
    other.map_or_else(|| "`biped doctor` lists the running sessions".into(), of_other)
}
