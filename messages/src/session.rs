//! A session: one plant, one controller and any number of recorders, under one name.
//!
//! Every file of a session lies in /dev/shm and begins with a prefix of its own. Sessions therefore do not interfere, and the files
//! of one can be removed without touching another.
//!
//! | what | where |
//! |---|---|
//! | locks by which the members of a session know each other | `session/membership.rs` |
//! | files of sessions that ended because all processes were killed | `session/stale_session.rs` |
//! | incomplete files of a process that was killed while others go on | `session/stale_files.rs` |
//! | files in shared memory that belong to this user only | `session/private_file.rs` |
//! | free shared memory | `session/shm_usage.rs` |
//! | the scene of a session, for observers | `session/scene.rs` |
//! | why a session of a name is not running | `session/absence.rs` |
//! | a socket for the members of a group | `session/share.rs` |

mod absence;
mod membership;
mod parent_process;
mod private_file;
mod scene;
mod share;
mod shm_usage;
mod stale_files;
mod stale_session;

pub use membership::Membership;
pub use parent_process::has_threads;
pub use private_file::user_name;
pub use share::{ShareListener, SharedSession, group};
pub use shm_usage::{REQUIRED_FILES, SHARED_MEMORY, ShmUsage};
pub use stale_session::StaleSession;

use crate::error::PortError;
use crate::wire::{FNV_START, fnv1a};
use nix::errno::Errno;
use nix::fcntl::{FallocateFlags, fallocate};
use nix::unistd::getuid;
use std::fs::{File, read_link};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// End of the name of the file on which every member holds a lock.
const MEMBERS: &str = "members";
/// Beginning of the names of sessions that the user has not named.
const UNNAMED: &str = "run-";
/// Longest name of a session [characters].
const LONGEST_NAME: usize = 32;

/// A session, by its name.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Session {
    name: String,
}

impl Session {
    /// The session called `name`: 1 to 32 letters, digits or hyphens.
    ///
    /// # Errors
    /// [`PortError::SessionName`] if it is anything else.
    pub fn named(name: &str) -> Result<Session, PortError> {
        let good = name.bytes().all(|byte| byte.is_ascii_alphanumeric() || byte == b'-');
        match good && (1..=LONGEST_NAME).contains(&name.len()) {
            true => Ok(Session { name: name.into() }),
            false => Err(PortError::SessionName { name: name.into() }),
        }
    }

    /// A session with a name that no other session has.
    pub fn unique() -> Session {
        Session { name: format!("{UNNAMED}{}-{:08x}", std::process::id(), crate::clock::random() as u32) }
    }

    /// Whether the user has given it its name.
    pub fn is_named(&self) -> bool {
        !self.name.starts_with(UNNAMED)
    }

    /// Name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Beginning of the name of every file of the session. It contains a hash of user and name instead of the name, because the paths
    /// of sockets contain it twice and must stay below 108 bytes.
    pub fn prefix(&self) -> String {
        self.prefix_of(getuid().as_raw())
    }

    /// The same prefix for another user.
    fn prefix_of(&self, user: u32) -> String {
        let owner = fnv1a(FNV_START, &user.to_le_bytes());
        format!("biped_{:08x}_", fnv1a(owner, self.name.as_bytes()) as u32)
    }

    /// Numbers of the other users who have a session of this name. Each user has separate sessions.
    fn other_owners(&self) -> impl Iterator<Item = u32> {
        let lists = files("biped_").into_iter().filter(|path| path.to_string_lossy().ends_with(MEMBERS));
        lists.filter_map(|path| {
            let user = path.symlink_metadata().ok()?.uid();
            let theirs = path.file_name()?.to_str()? == self.prefix_of(user) + MEMBERS;
            (theirs && user != getuid().as_raw()).then_some(user)
        })
    }

    /// Removes the access of other users to the session's files. iceoryx2 0.10 lets everybody write to the file that counts its nodes.
    pub(crate) fn restrict_access(&self) {
        self.shm_files().iter().for_each(|path| private_file::restrict_access(path));
    }

    /// Folder of the session's files that are not shared memory.
    pub fn root(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + "files")
    }

    /// Every file of this session that is in shared memory now.
    pub fn shm_files(&self) -> Vec<PathBuf> {
        files(&self.prefix())
    }

    /// Reserves all memory that the session's segments may need. Otherwise the first access to a page could kill the process by SIGBUS
    /// when no memory is free.
    pub(crate) fn reserve(&self) -> Result<(), PortError> {
        for path in self.shm_files() {
            // A folder, or a file that has been removed in the meantime, cannot be opened.
            let Ok(file) = private_file::open(&path, File::options().write(true)) else { continue };
            let lacking = || file.metadata().ok().filter(|found| 512 * found.blocks() < found.len());
            if lacking().is_none() {
                continue; // its creator has reserved it
            }
            let _ = file.lock(); // two processes that reserve it at the same time take twice as long
            let Some(found) = lacking() else { continue };
            // Any other error leaves the memory as it was.
            let reserved = fallocate(&file, FallocateFlags::FALLOC_FL_KEEP_SIZE, 0, found.len() as i64);
            if reserved == Err(Errno::ENOSPC) {
                return Err(PortError::SharedMemory(format!("{SHARED_MEMORY} is full")));
            }
        }
        Ok(())
    }

    /// Every running session of this user.
    pub fn running() -> Vec<Session> {
        let names = files("").into_iter().filter(|path| path.to_string_lossy().ends_with(MEMBERS));
        let mut names: Vec<String> =
            names.filter_map(|path| private_file::read(&path, LONGEST_NAME as u64).ok()).collect();
        names.sort();
        names.iter().filter_map(|name| Session::named(name).ok()).filter(Session::is_running).collect()
    }

    /// Whether a process is in the session now.
    pub fn is_running(&self) -> bool {
        private_file::open(&self.lock_file(), File::options().read(true)).is_ok_and(|file| file.try_lock().is_err())
    }

    /// Checks that a process is in the session now.
    ///
    /// # Errors
    /// [`PortError::NoSession`], which says why.
    pub fn require_running(&self) -> Result<(), PortError> {
        let missing = || PortError::NoSession { session: self.name().into(), why: self.absence() };
        if self.is_running() { Ok(()) } else { Err(missing()) }
    }

    /// Numbers of the processes in the session that this user may see.
    pub fn members(&self) -> Vec<u32> {
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_string_lossy().parse().ok());
        let mut members: Vec<u32> = numbers.filter(|number| self.is_member(*number)).collect();
        members.sort_unstable();
        members
    }

    /// Whether the process of this number is in the session, as far as this user may see.
    fn is_member(&self, number: u32) -> bool {
        let (handles, list) = (std::fs::read_dir(format!("/proc/{number}/fd")), self.lock_file());
        let mut targets = handles.into_iter().flatten().flatten().filter_map(|handle| read_link(handle.path()).ok());
        targets.any(|target| target == list)
    }

    /// The file on which every member holds a lock.
    fn lock_file(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + MEMBERS)
    }
}

/// Files in shared memory whose names begin with `prefix`, in order.
fn files(prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let matching = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix));
    let mut found: Vec<_> = matching.map(|entry| entry.path()).collect();
    found.sort();
    found
}
