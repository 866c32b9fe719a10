//! Who is in a session: every member holds a shared lock on one file, which the system gives back even for the killed.

use super::{Session, StaleSession, private_file};
use crate::port::PortError;
use nix::fcntl::{FcntlArg, fcntl};
use nix::libc::{F_WRLCK, SEEK_SET, flock};
use std::fs::{File, Metadata};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::os::unix::process::parent_id;
use std::path::Path;
use std::time::{Duration, Instant};

/// Timeout of the last one out with the locks of a parent that has just been killed.
const ORPHANED_LOCK_TIMEOUT: Duration = Duration::from_millis(500);
/// And with somebody who only looks whether the session is running, which takes microseconds.
const STATUS_CHECK_TIME: Duration = Duration::from_millis(2);

impl Session {
    /// Enters the session. The first one in sweeps what killed processes left, here and in sessions that are dead.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    pub fn join(&self) -> Result<Membership, PortError> {
        let path = self.lock_file();
        let fail = |reason| PortError::SharedMemory(format!("{} cannot be locked: {reason}", path.display()));
        loop {
            let options = &mut File::options();
            let file =
                private_file::open(&path, options.read(true).write(true).create(true).truncate(false)).map_err(fail)?;
            if file.try_lock().is_ok() {
                self.shm_files().iter().filter(|left| **left != path).for_each(|left| remove(left));
                file.lock_shared().map_err(fail)?;
                StaleSession::all().iter().for_each(|dead| _ = dead.remove());
            }
            file.lock_shared().map_err(fail)?;
            // The last one out may have removed the file just before it was locked here.
            if is_current(&file, &path) {
                private_file::folder(&self.root()).map_err(fail)?;
                // told to whoever looks for running sessions
                file.write_all_at(self.name.as_bytes(), 0).map_err(fail)?;
                return Ok(Membership { session: self.clone(), file, parent: parent_id() });
            }
        }
    }
}

/// Whether this is the file that is there now, not one that has been removed.
pub(super) fn is_current(file: &File, path: &Path) -> bool {
    let same = |found: Metadata| file.metadata().is_ok_and(|mine| mine.ino() == found.ino());
    std::fs::metadata(path).is_ok_and(same)
}

/// Removes a file or folder; what somebody else has just removed is gone as well.
pub(super) fn remove(path: &Path) {
    let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

/// One process's part in a session. The last one out sweeps.
#[derive(Debug)]
pub struct Membership {
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

    /// How long to go on asking for the lock that is somebody else's.
    fn patience(&self) -> Duration {
        match self.is_orphaned() {
            // A parent that was killed, and whose death ends us, gives its lock back a moment later: with its last thread.
            true => ORPHANED_LOCK_TIMEOUT,
            // One that lives and is in the session is the last one out.
            false if self.session.is_member(self.parent) => Duration::ZERO,
            false => STATUS_CHECK_TIME,
        }
    }

    /// Whether the session's files are still there. Somebody may have removed them, as logind does (RemoveIPC) when a user's last login
    /// ends: who is in the session goes on, but nobody can join any more.
    pub fn can_be_joined(&self) -> bool {
        is_current(&self.file, &self.session.lock_file())
    }

    /// Takes the lead, which one member has at a time, as long as it is in the session: says whether it got it.
    pub fn try_lead(&self) -> bool {
        let first_byte = flock { l_type: F_WRLCK as _, l_whence: SEEK_SET as _, l_start: 0, l_len: 1, l_pid: 0 };
        fcntl(&self.file, FcntlArg::F_OFD_SETLK(&first_byte)).is_ok()
    }

    pub(crate) fn session(&self) -> &Session {
        &self.session
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        let start = Instant::now();
        let mut last = self.file.try_lock().is_ok();
        while !last && start.elapsed() < self.patience() {
            std::thread::sleep(Duration::from_millis(1));
            last = self.file.try_lock().is_ok();
        }
        if last && is_current(&self.file, &self.session.lock_file()) {
            StaleSession::at(&self.session.prefix()).clear();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Barrier;

    #[test]
    fn of_those_who_enter_at_once_one_has_the_lead() {
        for _ in 0..50 {
            let (session, gate) = (Session::unique(), Barrier::new(4));
            let enters = || {
                gate.wait();
                let member = session.join().expect("shared memory");
                let leads = member.try_lead();
                gate.wait(); // nobody leaves before all have asked
                leads
            };
            let leaders = std::thread::scope(|scope| {
                let all: Vec<_> = (0..4).map(|_| scope.spawn(enters)).collect();
                all.into_iter().filter_map(|one| one.join().ok()).filter(|leads| *leads).count()
            });
            assert_eq!(leaders, 1);
            assert!(session.shm_files().is_empty());
        }
    }

    #[test]
    fn the_lead_is_free_again_once_its_holder_has_left() {
        let session = Session::unique();
        let [first, second] = [0, 1].map(|_| session.join().expect("shared memory"));
        assert!(first.try_lead() && !second.try_lead());
        drop(first);
        assert!(second.try_lead());
    }
}
