//! Membership of a session: every member holds a shared lock on one file. The system releases the lock of a process that is killed.

use super::Session;
use super::parent_process::ParentProcess;
use super::private_file::{self, is_current, remove};
use super::stale_session::StaleSession;
use crate::error::PortError;
use nix::fcntl::{FcntlArg, fcntl};
use nix::libc::{F_WRLCK, SEEK_SET, flock};
use std::fs::File;
use std::os::unix::fs::FileExt;
use std::os::unix::process::parent_id;
use std::time::{Duration, Instant};

/// Longest wait of a leaving process for the lock of its parent, if that has just been killed: while it has threads, and after its last.
/// Its last thread may take seconds to end, while the machine writes much to a disk. A child of it that ends too may hold the lock longer.
const DYING_LOCK_TIMEOUT: Duration = Duration::from_secs(30);
const ORPHANED_LOCK_TIMEOUT: Duration = Duration::from_millis(500);
/// Longest wait for a process that only checks whether the session is running, which takes microseconds.
const STATUS_CHECK_TIME: Duration = Duration::from_millis(2);

impl Session {
    /// Joins the session. The first member removes the files of killed processes, in this session and in stale ones.
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
            // The last member may have removed the file just before this process locked it.
            if is_current(&file, &path) {
                private_file::folder(&self.root()).map_err(fail)?;
                // `Session::running` reads the name from here.
                file.write_all_at(self.name.as_bytes(), 0).map_err(fail)?;
                return Ok(Membership { session: self.clone(), file, parent: ParentProcess::of(parent_id()) });
            }
        }
    }
}

/// Membership of one process. The last member that leaves removes the session's files.
#[derive(Debug)]
pub struct Membership {
    session: Session,
    file: File,
    parent: ParentProcess,
}

impl Membership {
    /// Longest wait for a lock that another process holds.
    fn lock_timeout(&self) -> Duration {
        match self.parent.is_lost() {
            // The parent was killed, and this process ends because of that. The parent's lock is released with its last thread.
            true if self.parent.has_threads() => DYING_LOCK_TIMEOUT,
            true => ORPHANED_LOCK_TIMEOUT,
            // The parent is alive and in the session, so it leaves after this process.
            false if self.session.is_member(self.parent.number) => Duration::ZERO,
            false => STATUS_CHECK_TIME,
        }
    }

    /// Whether the session's files still exist. Another program may have removed them, as logind does (RemoveIPC) when the last login
    /// of a user ends. The members can go on, but no process can join any more.
    pub fn can_be_joined(&self) -> bool {
        is_current(&self.file, &self.session.lock_file())
    }

    /// Tries to become the leader. Only one member is the leader, until it leaves. Returns whether this process is the leader now.
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
        let (mut start, mut timeout) = (Instant::now(), self.lock_timeout());
        let mut last = self.file.try_lock().is_ok();
        while !last && start.elapsed() < timeout {
            std::thread::sleep(Duration::from_millis(1));
            // The parent is examined before the lock: it may end between the two. Each of its states has its own wait.
            let next = self.lock_timeout();
            if next != timeout {
                (start, timeout) = (Instant::now(), next);
            }
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
    use std::process::Command;
    use std::sync::Barrier;

    #[test]
    fn of_processes_that_join_at_the_same_time_one_becomes_the_leader() {
        for _ in 0..50 {
            let (session, barrier) = (Session::unique(), Barrier::new(4));
            let join = || {
                barrier.wait();
                let member = session.join().expect("shared memory");
                let leads = member.try_lead();
                barrier.wait(); // no member leaves before all have tried
                leads
            };
            let leaders = std::thread::scope(|scope| {
                let all: Vec<_> = (0..4).map(|_| scope.spawn(join)).collect();
                all.into_iter().filter_map(|one| one.join().ok()).filter(|leads| *leads).count()
            });
            assert_eq!(leaders, 1);
            assert!(session.shm_files().is_empty());
        }
    }

    #[test]
    fn another_member_can_lead_after_the_leader_has_left() {
        let session = Session::unique();
        let [first, second] = [0, 1].map(|_| session.join().expect("shared memory"));
        assert!(first.try_lead() && !second.try_lead());
        drop(first);
        assert!(second.try_lead());
    }

    /// Starts the command under a shared lock of the session's file, as a parent that dies, and lets a member leave.
    /// Returns how long that took.
    fn leave_a_parent_that_runs(command: &str) -> Duration {
        let session = Session::unique();
        let mut member = session.join().expect("shared memory");
        let (first, start) = (session.lock_file(), Instant::now());
        let mut dying =
            Command::new("flock").arg("--shared").arg(&first).args(["sh", "-c", command]).spawn().expect("flock");
        while !session.is_member(dying.id()) {
            assert!(dying.try_wait().expect("flock").is_none(), "flock has ended");
        }
        std::thread::sleep(Duration::from_millis(200)); // it has opened the file, and locks it
        member.parent = ParentProcess::of(dying.id());
        drop(member);
        assert!(session.shm_files().is_empty(), "files are left");
        dying.wait().expect("flock");
        start.elapsed()
    }

    /// The system may take seconds to end a process that was killed, while it still holds its lock.
    #[test]
    fn a_process_that_leaves_waits_for_its_dying_parent_and_removes_the_files() {
        assert!(leave_a_parent_that_runs("exec sleep 1.5") > Duration::from_secs(1), "it did not wait");
    }

    /// The parent ends after more than the time for which an orphan waits. A process that it started keeps its lock for a while.
    #[test]
    fn a_lock_that_outlives_a_dying_parent_is_waited_for() {
        leave_a_parent_that_runs("sleep 1.2 & exec sleep 1");
    }

    /// A shell that started a process in the background and ended may have left its number to another program.
    #[test]
    fn a_process_that_has_the_number_of_a_dead_parent_is_not_waited_for() {
        let session = Session::unique();
        let [first, second] = [0, 1].map(|_| session.join().expect("shared memory"));
        let later = ParentProcess::of(std::process::id()).started_before();
        assert!(later.is_lost() && !later.has_threads() && ParentProcess::of(later.number).has_threads());
        let (mut leaving, start) = (first, Instant::now());
        leaving.parent = later;
        drop(leaving);
        assert!(start.elapsed() < DYING_LOCK_TIMEOUT / 2);
        drop(second);
        assert!(session.shm_files().is_empty());
    }
}
