//! Free shared memory.

use crate::error::PortError;
use nix::errno::Errno;
use nix::sys::resource::{RLIM_INFINITY, Resource, getrlimit};
use nix::sys::statvfs::statvfs;
use nix::unistd::{AccessFlags, access};

/// Folder in which Linux shows POSIX shared memory as files.
pub const SHARED_MEMORY: &str = "/dev/shm";
/// Number of files that must be free when a session begins. A session has up to 35.
pub const REQUIRED_FILES: u64 = 64;

/// Size of shared memory, and how much of it is free.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ShmUsage {
    /// Total size [bytes].
    pub size: u64,
    /// Free memory [bytes].
    pub free: u64,
    /// Number of files that can still be created.
    pub files: u64,
}

impl ShmUsage {
    /// The present state.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if there is no shared memory, or this user may not write to it.
    pub fn now() -> Result<ShmUsage, PortError> {
        let unusable = |what: &str, reason: Errno| {
            PortError::SharedMemory(format!("{SHARED_MEMORY} cannot be {what}: {}", reason.desc()))
        };
        let stat = statvfs(SHARED_MEMORY).map_err(|reason| unusable("examined", reason))?;
        access(SHARED_MEMORY, AccessFlags::W_OK | AccessFlags::X_OK)
            .map_err(|reason| unusable("written to", reason))?;
        let unit = stat.fragment_size() as u64;
        let files = if stat.files() == 0 { u64::MAX } else { stat.files_available() }; // 0 means no limit
        Ok(ShmUsage { size: stat.blocks() as u64 * unit, free: stat.blocks_available() as u64 * unit, files })
    }

    /// Checks that this much memory is free, and that a file of it may have a third of that size. When shared memory is full, the system
    /// kills a process by SIGBUS and reports no error.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`] if less is free, or allowed.
    pub fn require(bytes: u64) -> Result<(), PortError> {
        let (largest, allowed) = (bytes / 3, getrlimit(Resource::RLIMIT_FSIZE).map_or(RLIM_INFINITY, |(soft, _)| soft));
        if allowed < largest {
            let words = format!(
                "the limit of the size of files is {} kB, but {} kB are needed: `ulimit -f unlimited`",
                allowed >> 10,
                largest >> 10
            );
            return Err(PortError::SharedMemory(words));
        }
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
