//! What a process left half made or half removed in a session that others are in, because it was killed amid that; it
//! would be in the way of whoever takes its place (iceoryx2 0.10).

use super::Session;
use std::ffi::OsString;
use std::fs::{Metadata, read_dir};
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// What is half done for so long is never finished: the living take microseconds.
const STALE_AFTER: Duration = Duration::from_millis(100);
/// It is looked at this often, so that the living are not waited for any longer.
const LOOK: Duration = Duration::from_millis(1);

impl Session {
    /// Removes what was left half made: segments without a size, for which whoever opens one as root waits for ever, and
    /// services of which not all was written.
    pub(crate) fn remove_incomplete_files(&self) {
        clear(|| {
            let all = self.shm_files().into_iter().chain(within(&self.services()));
            all.filter(|path| is_incomplete(path)).collect()
        });
    }

    /// Removes services that nobody uses: who was the last to use one was killed amid removing it. A process that makes,
    /// uses or removes a service has a tag of it among the files of its node; those of the dead must have been removed.
    pub(crate) fn remove_unused_services(&self) {
        clear(|| {
            // the services first: one that is made meanwhile has its tag before
            let services: Vec<PathBuf> = within(&self.services()).collect();
            let tags: Vec<OsString> = within(&self.root().join("nodes"))
                .flat_map(|node| within(&node))
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

/// Removes the files that `find` finds again and again.
fn clear(find: impl Fn() -> Vec<PathBuf>) {
    let (start, mut found) = (Instant::now(), find());
    while !found.is_empty() && start.elapsed() < STALE_AFTER {
        std::thread::sleep(LOOK);
        let still = find();
        found.retain(|path| still.contains(path));
    }
    found.iter().for_each(|path| _ = std::fs::remove_file(path));
}

/// What is in a folder; nothing if there is none.
fn within(folder: &Path) -> impl Iterator<Item = PathBuf> + use<> {
    read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path())
}

/// A segment may be read only when it is finished, a service only then no longer be written.
fn is_incomplete(path: &Path) -> bool {
    let is_service = path.extension().is_some_and(|end| end == "service");
    let is_it = |file: Metadata| match is_service {
        true => file.mode() & 0o200 != 0,
        false => file.is_file() && file.len() == 0 && file.mode() & 0o777 == 0o200,
    };
    path.symlink_metadata().is_ok_and(is_it)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::cell::Cell;

    #[test]
    fn what_is_finished_meanwhile_is_not_waited_for() {
        let session = Session::unique();
        let _member = session.join().expect("shared memory"); // or whoever enters a session sweeps this one
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
    fn what_nobody_uses_goes_and_what_somebody_uses_stays() {
        let session = Session::unique();
        let member = session.join().expect("shared memory"); // or whoever enters a session sweeps this one
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
