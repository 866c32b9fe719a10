//! What is left of sessions that nobody is in any more, because all of it was killed at once.

use super::membership::{is_current, remove};
use super::{LONGEST_NAME, MEMBERS, SHARED_MEMORY, files, private_file};
use std::fs::File;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

/// Length of a session's prefix: `biped_`, eight digits, `_`.
const PREFIX: usize = 15;

/// Whether a session has such a prefix: files of others may begin like ours.
fn is_ours(prefix: &str) -> bool {
    let digits = prefix.strip_prefix("biped_").and_then(|rest| rest.strip_suffix('_'));
    digits.is_some_and(|digits| digits.bytes().all(|digit| matches!(digit, b'0'..=b'9' | b'a'..=b'f')))
}

/// The files of one session.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct StaleSession {
    prefix: String,
    /// In order.
    pub files: Vec<PathBuf>,
}

impl StaleSession {
    /// Those of every session of this user that nobody is in.
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

    /// Name of the session, if that can still be read.
    pub fn name(&self) -> Option<String> {
        private_file::read(&self.lock_file(), LONGEST_NAME as u64).ok().filter(|name| !name.is_empty())
    }

    /// Their room in shared memory [bytes].
    pub fn bytes(&self) -> u64 {
        self.files.iter().filter_map(|path| path.symlink_metadata().ok()).map(|file| file.blocks() * 512).sum()
    }

    /// Removes them, unless somebody is in the session or enters it just now; says whether.
    pub fn remove(&self) -> bool {
        // The lock that whoever enters waits for.
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

    /// Removes them for whoever holds the lock; the file with the lock last, for without it nobody else waits.
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
