//! Errors of the connection between the processes of a session.

use crate::exit::Exit;
use nix::unistd::User;
use std::fmt::{self, Debug};
use thiserror::Error;

/// Why a connection could not be opened, or why it failed.
#[derive(Debug, Error)]
pub enum PortError {
    /// The name of a session is not allowed.
    #[error("{}", not_a_name(.name))]
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
    #[error("no session `{session}` is running: {why}")]
    NoSession {
        /// Name of the session.
        session: String,
        /// Why, and how to find the right session.
        why: Absence,
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

/// Why no session of a name is running, as far as this user can see.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Absence {
    /// There is none.
    Unknown,
    /// Its files are left, but all its processes were killed.
    Killed,
    /// Another user has one.
    Foreign {
        /// Name of that user.
        owner: String,
        /// Whether it has a share.
        shared: bool,
    },
}

impl fmt::Display for Absence {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self {
            Absence::Unknown => {
                write!(f, "`biped doctor` lists the running sessions; `biped run` and `biped plant` start one")
            }
            Absence::Killed => {
                write!(f, "its processes were killed; start it again, or remove its files by `biped clean`")
            }
            Absence::Foreign { owner, shared } => {
                let share = if *shared { ", apart from `biped top` and requests by --session OWNER/NAME" } else { "" };
                write!(
                    f,
                    "the session of that name belongs to user {owner}, and only processes of {owner} can join it{share}: \
                     run this as {owner}, or use another name"
                )
            }
        }
    }
}

impl PortError {
    /// The exit code with which a process ends that cannot go on.
    pub fn exit_code(&self) -> Exit {
        match self {
            PortError::SessionName { .. } | PortError::Share(_) => Exit::Usage,
            PortError::NoSession { .. } | PortError::Absent { .. } => Exit::PeerMissing,
            PortError::Incompatible { .. }
            | PortError::Foreign { .. }
            | PortError::Taken { .. }
            | PortError::Crowded { .. } => Exit::Incompatible,
            PortError::SharedMemory(_) => Exit::SharedMemory,
        }
    }

    /// An operation of iceoryx2 failed for this reason.
    pub(crate) fn failed(what: &str, reason: impl Debug) -> PortError {
        PortError::SharedMemory(format!("{what} failed: {reason:?}"))
    }
}

/// Why a text cannot name a session of this user.
fn not_a_name(text: &str) -> String {
    // a user without an entry in the list of users has a number only
    let is_user = |owner: &str| owner.parse::<u32>().is_ok() || User::from_name(owner).is_ok_and(|user| user.is_some());
    match text.split_once('/') {
        Some((owner, name)) if is_user(owner) => format!(
            "`{text}` is a session of user {owner}: only `biped top` and requests such as `biped push` reach it. \
             Run this as {owner} with the name {name}"
        ),
        _ => format!("`{text}` cannot name a session: use 1 to 32 letters, digits or hyphens"),
    }
}
