//! Files in shared memory that are this user's own. Everybody may write to /dev/shm: what lies there under one of our names may be
//! somebody else's, a link or a pipe. So nothing is followed, nothing is waited for, and no more is read than belongs there.

use nix::fcntl::OFlag;
use nix::unistd::{Uid, User, getuid};
use std::fs::{DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

/// What group and others may do with a file.
const OTHERS: u32 = 0o077;
/// Writing by them.
const WRITTEN_BY_OTHERS: u32 = 0o022;

/// Opens a regular file of this user; one that is made is for this user alone.
pub(super) fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    let file = options.mode(0o600).custom_flags((OFlag::O_NOFOLLOW | OFlag::O_NONBLOCK).bits()).open(path);
    // where it cannot be opened, for a link, a pipe that nobody reads, or somebody else's: say which
    let found = file.as_ref().map_or_else(|_| path.symlink_metadata(), File::metadata);
    match found.map(|found| (flaw(&found), found.is_file())) {
        Ok((Some(flaw), _)) => Err(foreign(path, &flaw)),
        Ok((None, false)) => Err(foreign(path, "is no regular file")),
        _ => file,
    }
}

/// Reads text, but no more bytes than so many.
pub(super) fn read(path: &Path, limit: u64) -> io::Result<String> {
    let mut text = String::new();
    open(path, OpenOptions::new().read(true))?.take(limit).read_to_string(&mut text)?;
    Ok(text)
}

/// Makes a folder for this user alone; one that is there must be this user's, and nobody else may write to it.
pub(super) fn folder(path: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => (),
        made => return made,
    }
    let found = path.symlink_metadata()?;
    match flaw(&found) {
        Some(flaw) => Err(foreign(path, &flaw)),
        None if !found.is_dir() => Err(foreign(path, "is no folder")),
        None if found.mode() & WRITTEN_BY_OTHERS != 0 => Err(foreign(path, "may be written to by others")),
        None => Ok(()),
    }
}

/// Takes all rights from group and others.
pub(super) fn restrict_access(path: &Path) {
    let open = |found: Metadata| found.is_file() && found.mode() & OTHERS != 0;
    if path.symlink_metadata().is_ok_and(open)
        && let Ok(file) = self::open(path, OpenOptions::new().read(true))
    {
        let _ = file.set_permissions(Permissions::from_mode(0o600)); // it may just have been removed
    }
}

/// Whose it is.
pub(super) fn owner(number: u32) -> String {
    let user = User::from_uid(Uid::from_raw(number)).ok().flatten();
    user.map_or_else(|| number.to_string(), |user| user.name)
}

/// What is wrong with the owner.
fn flaw(found: &Metadata) -> Option<String> {
    let ours = found.uid() == getuid().as_raw();
    (!ours).then(|| format!("belongs to user {}", owner(found.uid())))
}

fn foreign(path: &Path, flaw: &str) -> io::Error {
    io::Error::new(
        ErrorKind::PermissionDenied,
        format!("{} {flaw}: remove it, or use another --session", path.display()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nix::sys::stat::Mode;
    use nix::unistd::mkfifo;
    use std::os::unix::fs::symlink;

    /// A folder of its own, gone at the end.
    struct Scratch(std::path::PathBuf);

    impl Scratch {
        fn new(name: &str) -> Scratch {
            let folder = std::env::temp_dir().join(format!("biped-own-{name}-{}", std::process::id()));
            std::fs::create_dir_all(&folder).expect("a folder");
            Scratch(folder)
        }
    }

    impl Drop for Scratch {
        fn drop(&mut self) {
            std::fs::remove_dir_all(&self.0).expect("it is there");
        }
    }

    #[test]
    fn pipes_links_and_folders_are_neither_waited_for_nor_followed() {
        let scratch = Scratch::new("kinds");
        let [pipe, link, folder, good] = ["pipe", "link", "folder", "good"].map(|name| scratch.0.join(name));
        mkfifo(&pipe, Mode::S_IRWXU).expect("a pipe");
        std::fs::write(&good, "words").expect("a file");
        symlink(&good, &link).expect("a link");
        std::fs::create_dir(&folder).expect("a folder");
        for bad in [&pipe, &link, &folder] {
            for options in [OpenOptions::new().read(true), OpenOptions::new().read(true).write(true).create(true)] {
                let words = open(bad, options).expect_err("refused").to_string();
                assert!(words.contains("is no regular file"), "{words}");
            }
        }
        assert_eq!(read(&good, 3).expect("text"), "wor");
        let missing = open(&scratch.0.join("none"), OpenOptions::new().read(true)).expect_err("none");
        assert_eq!(missing.kind(), ErrorKind::NotFound);
    }

    #[test]
    fn a_folder_to_which_others_may_write_is_refused_and_a_file_is_closed_to_them() {
        let scratch = Scratch::new("rights");
        let (folder, file) = (scratch.0.join("root"), scratch.0.join("file"));
        super::folder(&folder).expect("made");
        super::folder(&folder).expect("it is ours");
        std::fs::set_permissions(&folder, Permissions::from_mode(0o777)).expect("ours");
        let words = super::folder(&folder).expect_err("refused").to_string();
        assert!(words.contains("may be written to by others"), "{words}");
        std::fs::write(&file, "").expect("a file");
        std::fs::set_permissions(&file, Permissions::from_mode(0o666)).expect("ours");
        restrict_access(&file);
        assert_eq!(file.metadata().expect("there").mode() & 0o777, 0o600);
    }
}
