//! Incomplete files of a process that was killed while it created or removed them, in a session that other processes are still in.
//! They would block its successor (iceoryx2 0.10).

use super::Session;
use std::ffi::OsString;
use std::fs::{Metadata, read_dir};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// A file that is incomplete for this long belongs to a process that was killed. A live process takes microseconds.
const STALE_AFTER: Duration = Duration::from_millis(100);
/// Interval of the checks for incomplete files.
const CHECK_INTERVAL: Duration = Duration::from_millis(1);

impl Session {
    /// Removes incomplete files: segments without a size, and service files that were not written completely. A process of root that
    /// opens a segment without a size waits for ever.
    pub(crate) fn remove_incomplete_files(&self) {
        clear(|| {
            let all = self.shm_files().into_iter().chain(files_in(&self.services()));
            all.filter(|path| is_incomplete(path)).collect()
        });
    }

    /// Removes service files that no process uses. Their last user was killed while it removed the file. A process that creates, uses or
    /// removes a service keeps a tag of it in the folder of its node. The tags of dead nodes must already have been removed.
    pub(crate) fn remove_unused_services(&self) {
        clear(|| {
            // The services are listed first, because a service that is created meanwhile has its tag before its file.
            let services: Vec<PathBuf> = files_in(&self.services()).collect();
            let tags: Vec<OsString> = files_in(&self.root().join("nodes"))
                .flat_map(|node| files_in(&node))
                .filter(|path| path.extension().is_some_and(|end| end == "service_tag"))
                .filter_map(|path| path.file_stem().map(Into::into))
                .collect();
            let is_used = |path: &PathBuf| path.file_stem().is_some_and(|name| tags.iter().any(|tag| tag == name));
            services.into_iter().filter(|path| !is_used(path)).collect()
        });
    }

    fn services(&self) -> PathBuf {
        self.root().join("services")
    }
}

/// Removes the files that `find` returns each time until [`STALE_AFTER`] is over.
fn clear(find: impl Fn() -> Vec<PathBuf>) {
    let (start, mut found) = (Instant::now(), find());
    while !found.is_empty() && start.elapsed() < STALE_AFTER {
        std::thread::sleep(CHECK_INTERVAL);
        let still = find();
        found.retain(|path| still.contains(path));
    }
    found.iter().for_each(|path| _ = std::fs::remove_file(path));
}

/// Content of a folder; empty if the folder does not exist.
fn files_in(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

/// Whether a file is incomplete. iceoryx2 makes a segment readable, and a service file read-only, when it is complete.
fn is_incomplete(path: &Path) -> bool {
    let is_service = path.extension().is_some_and(|end| end == "service");
    let incomplete = |file: Metadata| match is_service {
        true => file.mode() & 0o200 != 0,
        false => file.is_file() && file.len() == 0 && file.mode() & 0o777 == 0o200,
    };
    path.symlink_metadata().is_ok_and(incomplete)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn files_that_become_complete_are_kept_without_a_long_wait() {
        let session = Session::unique();
        let _member = session.join().expect("shared memory"); // otherwise a process that joins another session would remove the files of this one
        let file = session.root().with_extension("half");
        let clearing = |finds: u32| {
            let (start, left) = (Instant::now(), Cell::new(finds));
            std::fs::write(&file, "").expect("a file");
            clear(|| {
                left.set(left.get().saturating_sub(1));
                if left.get() > 0 { vec![file.clone()] } else { vec![] }
            });
            (start.elapsed(), file.exists())
        };
        let (long, abandoned) = clearing(u32::MAX);
        let living = (0..5).map(|_| clearing(3)).min().expect("five");
        std::fs::remove_file(&file).expect("it is there still");
        assert!(!abandoned && living.1 && 2 * living.0 < long, "{living:?} beside {long:?}");
    }

    #[test]
    fn unused_services_are_removed_and_used_ones_stay() {
        let session = Session::unique();
        let member = session.join().expect("shared memory"); // otherwise a process that joins another session would remove the files of this one
        let node = session.root().join("nodes/1");
        let services: [PathBuf; 2] = ["used", "unused"].map(|name| session.services().join(format!("{name}.service")));
        std::fs::create_dir_all(&node).expect("a folder");
        std::fs::create_dir_all(session.services()).expect("a folder");
        services.iter().for_each(|path| std::fs::write(path, "").expect("a file"));
        std::fs::write(node.join("used.service_tag"), "").expect("a file");
        session.remove_unused_services();
        assert_eq!(services.map(|path| path.exists()), [true, false]);
        drop(member);
        assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    }
}
