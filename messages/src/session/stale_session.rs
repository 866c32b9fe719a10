//! Stale sessions: their files remain because all their processes were killed at the same time.

use super::private_file::{self, is_current, remove};
use super::{LONGEST_NAME, MEMBERS, SHARED_MEMORY, Session, files};
use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Length of a session's prefix: `biped_`, eight digits, `_`.
const PREFIX: usize = 15;

/// Whether a prefix has the form of a session's. Files of other programs may begin in the same way.
fn is_ours(prefix: &str) -> bool {
    let digits = prefix.strip_prefix("biped_").and_then(|rest| rest.strip_suffix('_'));
    digits.is_some_and(|digits| digits.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f')))
}

/// The files of one session that is not running.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaleSession {
    prefix: String,
    /// Files, in order.
    pub files: Vec<PathBuf>,
}

impl Session {
    /// Removes every file of this session, unless a process is in it. This includes the empty segments of a process that was killed
    /// while it created one.
    pub fn remove_files(&self) {
        StaleSession::at(&self.prefix()).remove();
    }
}

impl StaleSession {
    /// Every stale session of this user.
    pub fn all() -> Vec<StaleSession> {
        let user = nix::unistd::getuid().as_raw();
        let ours = |path: &PathBuf| path.symlink_metadata().is_ok_and(|file| file.uid() == user);
        let prefix = |path: PathBuf| Some(path.file_name()?.to_str()?.get(..PREFIX)?.to_string());
        let mut prefixes: Vec<String> = files("biped_").into_iter().filter(ours).filter_map(prefix).collect();
        prefixes.retain(|prefix| is_ours(prefix));
        prefixes.dedup();
        prefixes.iter().map(|prefix| StaleSession::at(prefix)).filter(StaleSession::is_dead).collect()
    }

    pub(super) fn at(prefix: &str) -> StaleSession {
        StaleSession { prefix: prefix.into(), files: files(prefix) }
    }

    /// Name of the session, if it can still be read.
    pub fn name(&self) -> Option<String> {
        private_file::read(&self.lock_file(), LONGEST_NAME as u64).ok().filter(|name| !name.is_empty())
    }

    /// Shared memory that the files use [bytes].
    pub fn bytes(&self) -> u64 {
        self.files.iter().filter_map(|path| path.symlink_metadata().ok()).map(|file| file.blocks() * 512).sum()
    }

    /// Removes the files, unless a process is in the session or is joining it. Returns whether they were removed.
    pub fn remove(&self) -> bool {
        // A process that joins the session waits for this lock.
        let list = self.lock_file();
        let options = &mut File::options();
        let Ok(file) = private_file::open(&list, options.read(true).write(true).create(true).truncate(false)) else {
            return false;
        };
        let nobody = file.try_lock().is_ok() && is_current(&file, &list);
        if nobody {
            StaleSession::at(&self.prefix).clear();
        }
        nobody
    }

    /// Removes the files. The caller must hold the lock. The file with the lock goes last, because other processes wait for it.
    pub(super) fn clear(&self) {
        let list = self.lock_file();
        self.files.iter().filter(|path| **path != list).for_each(|path| remove(path));
        remove(&list);
    }

    fn is_dead(&self) -> bool {
        private_file::open(&self.lock_file(), File::options().read(true)).map_or(true, |file| file.try_lock().is_ok())
    }

    fn lock_file(&self) -> PathBuf {
        Path::new(SHARED_MEMORY).join(self.prefix.clone() + MEMBERS)
    }
}
