//! A session: one plant, one controller and whoever records, under a name of their own.
//!
//! Every file that a session makes lies in /dev/shm and begins with a prefix of its own, so that sessions live side by
//! side and one can be cleared away without touching another.

use crate::port::PortError;
use crate::wire::{FNV_START, fnv1a};
use nix::sys::statvfs::statvfs;
use std::fs::{File, Metadata};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::os::unix::process::parent_id;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Where POSIX shared memory shows as files on Linux.
const SHARED_MEMORY: &str = "/dev/shm";
/// End of the name of the file on which every member holds a lock.
const MEMBERS: &str = "members";
/// Patience of the last one out with the locks of a parent that has just been killed.
const ORPHANED: Duration = Duration::from_millis(500);

/// Name of a session and of everything that belongs to it.
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
        match good && (1..=32).contains(&name.len()) {
            true => Ok(Session { name: name.into() }),
            false => Err(PortError::SessionName { name: name.into() }),
        }
    }

    /// A session that nobody else has.
    pub fn unique() -> Session {
        Session { name: format!("run-{}-{:08x}", std::process::id(), crate::clock::random() as u32) }
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Start of the name of every file of the session: a hash of user and name, because the paths of its sockets, which
    /// hold it twice, must stay below 108 bytes.
    pub(crate) fn prefix(&self) -> String {
        let owner = fnv1a(FNV_START, &nix::unistd::getuid().as_raw().to_le_bytes());
        format!("biped_{:08x}_", fnv1a(owner, self.name.as_bytes()) as u32)
    }

    /// Folder of the session's other files.
    pub(crate) fn root(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + "files")
    }

    /// Everything of this session that is in shared memory now.
    pub fn leftovers(&self) -> Vec<PathBuf> {
        let prefix = self.prefix();
        let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
        let mut found: Vec<_> = entries
            .filter(|entry| entry.file_name().to_string_lossy().starts_with(&prefix))
            .map(|entry| entry.path())
            .collect();
        found.sort();
        found
    }

    /// Removes everything of this session, for whoever knows that nobody of it is alive; also the empty segments that
    /// a process leaves when it is killed while making one.
    pub fn sweep(&self) {
        self.leftovers().iter().for_each(|path| remove(path));
    }

    /// Every session of this user that somebody is in now.
    pub fn running() -> Vec<Session> {
        let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
        let names = entries.filter(|entry| entry.file_name().to_string_lossy().ends_with(MEMBERS));
        let mut names: Vec<String> = names.filter_map(|entry| std::fs::read_to_string(entry.path()).ok()).collect();
        names.sort();
        names.iter().filter_map(|name| Session::named(name).ok()).filter(Session::is_running).collect()
    }

    /// Whether somebody is in it now.
    pub fn is_running(&self) -> bool {
        File::open(self.members()).is_ok_and(|file| file.try_lock().is_err())
    }

    /// Enters the session; the first one in sweeps what killed processes left.
    pub(crate) fn enter(&self) -> Result<Membership, PortError> {
        let path = self.members();
        let fail = |reason| PortError::SharedMemory(format!("{} cannot be locked: {reason}", path.display()));
        loop {
            let file = File::options().read(true).write(true).create(true).truncate(false).open(&path).map_err(fail)?;
            if file.try_lock().is_ok() {
                self.leftovers().iter().filter(|left| **left != path).for_each(|left| remove(left));
                // told to whoever looks for running sessions
                file.write_all_at(self.name.as_bytes(), 0)
                    .and_then(|()| file.set_len(self.name.len() as u64))
                    .map_err(fail)?;
            }
            file.lock_shared().map_err(fail)?;
            // The last one out may have removed the file just before it was locked here.
            if self.is_locked_by(&file) {
                return Ok(Membership { session: self.clone(), file, parent: parent_id() });
            }
        }
    }

    /// The file on which every member holds a lock.
    fn members(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + MEMBERS)
    }

    /// Whether this is the present file of members, not one that has been removed.
    fn is_locked_by(&self, file: &File) -> bool {
        let same = |found: Metadata| file.metadata().is_ok_and(|mine| mine.ino() == found.ino());
        std::fs::metadata(self.members()).is_ok_and(same)
    }

    /// Full shared memory kills by SIGBUS instead of an error, so room is demanded beforehand.
    pub(crate) fn demand(&self, bytes: u64) -> Result<(), PortError> {
        let stat = statvfs(SHARED_MEMORY)
            .map_err(|reason| PortError::SharedMemory(format!("{SHARED_MEMORY} cannot be examined: {reason}")))?;
        let free = stat.blocks_available() as u64 * stat.fragment_size() as u64;
        match free >= bytes {
            true => Ok(()),
            false => Err(PortError::SharedMemory(format!(
                "{SHARED_MEMORY} has {} MB free, but {} MB are needed: remove files there, or enlarge it",
                free >> 20,
                bytes >> 20,
            ))),
        }
    }
}

fn remove(path: &Path) {
    // What somebody else has just removed is gone as well.
    let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

/// One process's part in a session: a shared lock, which the system gives back even for the killed. The last one out
/// sweeps.
#[derive(Debug)]
pub(crate) struct Membership {
    session: Session,
    file: File,
    parent: u32,
}

impl Membership {
    /// Whether the parent has ended, or its first thread, which the system takes for it, has.
    fn is_orphaned(&self) -> bool {
        let stat = std::fs::read_to_string(format!("/proc/{}/stat", self.parent)).unwrap_or_default();
        let state = stat.rsplit(')').next().and_then(|rest| rest.trim_start().chars().next());
        parent_id() != self.parent || state.is_none_or(|state| "ZX".contains(state))
    }

    pub(crate) fn session(&self) -> &str {
        self.session.name()
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        let start = Instant::now();
        let mut last = self.file.try_lock().is_ok();
        // A parent that was killed, and whose death ends us, gives its lock back a moment later: with its last thread.
        while !last && self.is_orphaned() && start.elapsed() < ORPHANED {
            std::thread::sleep(Duration::from_millis(1));
            last = self.file.try_lock().is_ok();
        }
        if last && self.session.is_locked_by(&self.file) {
            self.session.sweep();
        }
    }
}
