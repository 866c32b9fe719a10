//! A session: one plant, one controller and whoever records, under a name of their own.
//!
//! Every file that a session makes lies in /dev/shm and begins with a prefix of its own, so that sessions live side by
//! side and one can be cleared away without touching another. Who is in it is told by locks (`member`), and so is what
//! nobody is in any more (`remains`). What somebody was killed amid making or removing is in `half_done`.

mod membership;
mod private_file;
mod scene;
mod stale_files;
mod stale_session;

use crate::port::PortError;
use crate::wire::{FNV_START, fnv1a};
pub use membership::Membership;
use nix::errno::Errno;
use nix::fcntl::{FallocateFlags, fallocate};
use nix::sys::statvfs::statvfs;
use nix::unistd::{AccessFlags, access, getuid};
pub use stale_session::StaleSession;
use std::fs::{File, read_link};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Where POSIX shared memory shows as files on Linux.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// Files that a session needs, with room to spare: it has 24.
pub const REQUIRED_FILES: u64 = 64;
/// End of the name of the file on which every member holds a lock.
const MEMBERS: &str = "members";
/// Begin of the names that nobody gave.
const UNNAMED: &str = "run-";
/// Letters of a name.
const LONGEST_NAME: usize = 32;

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
        match good && (1..=LONGEST_NAME).contains(&name.len()) {
            true => Ok(Session { name: name.into() }),
            false => Err(PortError::SessionName { name: name.into() }),
        }
    }

    /// A session that nobody else has.
    pub fn unique() -> Session {
        Session { name: format!("{UNNAMED}{}-{:08x}", std::process::id(), crate::clock::random() as u32) }
    }

    /// Whether somebody gave it its name.
    pub fn is_named(&self) -> bool {
        !self.name.starts_with(UNNAMED)
    }

    /// Its name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Start of the name of every file of the session: a hash of user and name, because the paths of its sockets, which
    /// hold it twice, must stay below 108 bytes.
    pub fn prefix(&self) -> String {
        self.prefix_of(getuid().as_raw())
    }

    /// The same of another user's.
    fn prefix_of(&self, user: u32) -> String {
        let owner = fnv1a(FNV_START, &user.to_le_bytes());
        format!("biped_{:08x}_", fnv1a(owner, self.name.as_bytes()) as u32)
    }

    /// Another user who has a session of this name: sessions are each user's own.
    pub(crate) fn other_owner(&self) -> Option<String> {
        let lists = files("biped_").into_iter().filter(|path| path.to_string_lossy().ends_with(MEMBERS));
        let mut owners = lists.filter_map(|path| {
            let user = path.symlink_metadata().ok()?.uid();
            let theirs = path.file_name()?.to_str()? == self.prefix_of(user) + MEMBERS;
            (theirs && user != getuid().as_raw()).then(|| private_file::owner(user))
        });
        owners.next()
    }

    /// Takes all rights to the session's files from other users: iceoryx2 0.10 lets everybody write to one of them, which counts
    /// nodes.
    pub(crate) fn restrict_access(&self) {
        self.shm_files().iter().for_each(|path| private_file::restrict_access(path));
    }

    /// Folder of the session's other files.
    pub fn root(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix() + "files")
    }

    /// Everything of this session that is in shared memory now.
    pub fn shm_files(&self) -> Vec<PathBuf> {
        files(&self.prefix())
    }

    /// Removes everything of this session, also the empty segments that a process leaves when it is killed while making
    /// one; unless somebody is in it.
    pub fn remove_files(&self) {
        StaleSession::at(&self.prefix()).remove();
    }

    /// Takes all the room that the session's segments may ever need: a page that is first touched when nothing is free any
    /// more kills by SIGBUS.
    pub(crate) fn reserve(&self) -> Result<(), PortError> {
        for path in self.shm_files() {
            // a folder, or gone in the meantime
            let Ok(file) = private_file::open(&path, File::options().write(true)) else { continue };
            let lacking = || file.metadata().ok().filter(|found| 512 * found.blocks() < found.len());
            if lacking().is_none() {
                continue; // whoever made it has taken it
            }
            let _ = file.lock(); // two that take it at once take twice as long
            let Some(found) = lacking() else { continue };
            // Where room cannot be reserved for another reason, it is as it was.
            let reserved = fallocate(&file, FallocateFlags::FALLOC_FL_KEEP_SIZE, 0, found.len() as i64);
            if reserved == Err(Errno::ENOSPC) {
                return Err(PortError::SharedMemory(format!("{SHARED_MEMORY} is full")));
            }
        }
        Ok(())
    }

    /// Every session of this user that somebody is in now.
    pub fn running() -> Vec<Session> {
        let names = files("").into_iter().filter(|path| path.to_string_lossy().ends_with(MEMBERS));
        let mut names: Vec<String> =
            names.filter_map(|path| private_file::read(&path, LONGEST_NAME as u64).ok()).collect();
        names.sort();
        names.iter().filter_map(|name| Session::named(name).ok()).filter(Session::is_running).collect()
    }

    /// Whether somebody is in it now.
    pub fn is_running(&self) -> bool {
        private_file::open(&self.lock_file(), File::options().read(true)).is_ok_and(|file| file.try_lock().is_err())
    }

    /// Numbers of the processes that are in it, as far as they are this user's to see.
    pub fn members(&self) -> Vec<u32> {
        let entries = std::fs::read_dir("/proc").into_iter().flatten().flatten();
        let numbers = entries.filter_map(|entry| entry.file_name().to_string_lossy().parse().ok());
        let mut members: Vec<u32> = numbers.filter(|number| self.is_member(*number)).collect();
        members.sort_unstable();
        members
    }

    /// Whether the process of this number is in it, as far as that is this user's to see.
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

/// Size of shared memory and what is free of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShmUsage {
    /// All of it [bytes].
    pub size: u64,
    /// What is left [bytes].
    pub free: u64,
    /// Files that may still be made.
    pub files: u64,
}

impl ShmUsage {
    /// As it is now.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is none, or this user may not write to it.
    pub fn now() -> Result<ShmUsage, PortError> {
        let unusable = |what: &str, reason: Errno| {
            PortError::SharedMemory(format!("{SHARED_MEMORY} cannot be {what}: {}", reason.desc()))
        };
        let stat = statvfs(SHARED_MEMORY).map_err(|reason| unusable("examined", reason))?;
        access(SHARED_MEMORY, AccessFlags::W_OK | AccessFlags::X_OK)
            .map_err(|reason| unusable("written to", reason))?;
        let unit = stat.fragment_size() as u64;
        let files = if stat.files() == 0 { u64::MAX } else { stat.files_available() }; // of 0 there is no limit
        Ok(ShmUsage { size: stat.blocks() as u64 * unit, free: stat.blocks_available() as u64 * unit, files })
    }

    /// Full shared memory kills by SIGBUS instead of an error, so room is demanded beforehand.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is less.
    pub fn require(bytes: u64) -> Result<(), PortError> {
        let ShmUsage { free, files, .. } = ShmUsage::now()?;
        let lack = |has: String, needed: String| {
            let words =
                format!("{SHARED_MEMORY} has {has} free, but {needed} are needed: remove files there, or enlarge it");
            Err(PortError::SharedMemory(words))
        };
        match (free >= bytes, files >= REQUIRED_FILES) {
            (true, true) => Ok(()),
            (false, _) => lack(format!("{} MB", free >> 20), format!("{} MB", bytes >> 20)),
            _ => lack(format!("room for {files} more files"), REQUIRED_FILES.to_string()),
        }
    }
}

/// What is in shared memory under names that begin so, in order.
fn files(prefix: &str) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(SHARED_MEMORY).into_iter().flatten().flatten();
    let of_it = entries.filter(|entry| entry.file_name().to_string_lossy().starts_with(prefix));
    let mut found: Vec<_> = of_it.map(|entry| entry.path()).collect();
    found.sort();
    found
}
