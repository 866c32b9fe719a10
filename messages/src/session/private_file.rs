//! Files in shared memory that belong to this user.
//!
//! Every user may write to /dev/shm. A file with the name of a session file may belong to another user, or be a link or a pipe.
//! Therefore these functions follow no links, never block on a pipe, and limit how much they read.

use nix::fcntl::OFlag;
use nix::unistd::{Uid, User, getuid};
use std::fs::{DirBuilder, File, Metadata, OpenOptions, Permissions};
use std::io::{self, ErrorKind, Read};
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

/// Permissions of group and others.
const OTHERS: u32 = 0o077;
/// Write permission of group and others.
const WRITTEN_BY_OTHERS: u32 = 0o022;

/// Opens a regular file of this user. A new file is accessible to this user only.
pub(super) fn open(path: &Path, options: &mut OpenOptions) -> io::Result<File> {
    let file = options.mode(0o600).custom_flags((OFlag::O_NOFOLLOW | OFlag::O_NONBLOCK).bits()).open(path);
    // If the file cannot be opened, its metadata show why: a link, a pipe without a reader, or a file of another user.
    let found = file.as_ref().map_or_else(|_| path.symlink_metadata(), File::metadata);
    match found.map(|found| (owner_problem(&found), found.is_file())) {
        Ok((Some(owner_problem), _)) => Err(access_error(path, &owner_problem)),
        Ok((None, false)) => Err(access_error(path, "is not a regular file")),
        _ => file,
    }
}

/// Reads text, at most `limit` bytes.
pub(super) fn read(path: &Path, limit: u64) -> io::Result<String> {
    let mut text = String::new();
    open(path, OpenOptions::new().read(true))?.take(limit).read_to_string(&mut text)?;
    Ok(text)
}

/// Creates a folder for this user only. An existing folder must belong to this user, and no other user may write to it.
pub(super) fn folder(path: &Path) -> io::Result<()> {
    match DirBuilder::new().mode(0o700).create(path) {
        Err(error) if error.kind() == ErrorKind::AlreadyExists => (),
        made => return made,
    }
    let found = path.symlink_metadata()?;
    match owner_problem(&found) {
        Some(owner_problem) => Err(access_error(path, &owner_problem)),
        None if !found.is_dir() => Err(access_error(path, "is not a folder")),
        None if found.mode() & WRITTEN_BY_OTHERS != 0 => Err(access_error(path, "is writable by other users")),
        None => Ok(()),
    }
}

/// Removes all permissions of group and others.
pub(super) fn restrict_access(path: &Path) {
    let open = |found: Metadata| found.is_file() && found.mode() & OTHERS != 0;
    if path.symlink_metadata().is_ok_and(open)
        && let Ok(file) = self::open(path, OpenOptions::new().read(true))
    {
        let _ = file.set_permissions(Permissions::from_mode(0o600)); // the file may just have been removed
    }
}

/// Whether `file` is the file that exists at this path now, and not one that has been removed.
pub(super) fn is_current(file: &File, path: &Path) -> bool {
    let same = |found: Metadata| file.metadata().is_ok_and(|mine| mine.ino() == found.ino());
    std::fs::metadata(path).is_ok_and(same)
}

/// Removes a file or folder. It is no error if another process has just removed it.
pub(super) fn remove(path: &Path) {
    let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

/// Name of a user, or the number if the user has no name.
pub fn user_name(number: u32) -> String {
    let user = User::from_uid(Uid::from_raw(number)).ok().flatten();
    user.map_or_else(|| number.to_string(), |user| user.name)
}

/// Why the owner of a file is wrong; `None` if it is right.
fn owner_problem(found: &Metadata) -> Option<String> {
    let ours = found.uid() == getuid().as_raw();
    (!ours).then(|| format!("belongs to user {}", user_name(found.uid())))
}

fn access_error(path: &Path, owner_problem: &str) -> io::Error {
    io::Error::new(
        ErrorKind::PermissionDenied,
        format!("{} {owner_problem}: remove it, or use another --session", path.display()),
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use nix::sys::stat::Mode;
    use nix::unistd::mkfifo;
    use std::os::unix::fs::symlink;

    /// A temporary folder that is removed at the end.
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
    fn pipes_links_and_folders_are_refused_without_blocking() {
        let scratch = Scratch::new("kinds");
        let [pipe, link, folder, good] = ["pipe", "link", "folder", "good"].map(|name| scratch.0.join(name));
        mkfifo(&pipe, Mode::S_IRWXU).expect("a pipe");
        std::fs::write(&good, "words").expect("a file");
        symlink(&good, &link).expect("a link");
        std::fs::create_dir(&folder).expect("a folder");
        for bad in [&pipe, &link, &folder] {
            for options in [OpenOptions::new().read(true), OpenOptions::new().read(true).write(true).create(true)] {
                let words = open(bad, options).expect_err("refused").to_string();
                assert!(words.contains("is not a regular file"), "{words}");
            }
        }
        assert_eq!(read(&good, 3).expect("text"), "wor");
        let missing = open(&scratch.0.join("none"), OpenOptions::new().read(true)).expect_err("none");
        assert_eq!(missing.kind(), ErrorKind::NotFound);
    }

    #[test]
    fn a_folder_writable_by_others_is_refused_and_a_file_is_closed_to_them() {
        let scratch = Scratch::new("rights");
        let (folder, file) = (scratch.0.join("root"), scratch.0.join("file"));
        super::folder(&folder).expect("made");
        super::folder(&folder).expect("it is ours");
        std::fs::set_permissions(&folder, Permissions::from_mode(0o777)).expect("ours");
        let words = super::folder(&folder).expect_err("refused").to_string();
        assert!(words.contains("is writable by other users"), "{words}");
        std::fs::write(&file, "").expect("a file");
        std::fs::set_permissions(&file, Permissions::from_mode(0o666)).expect("ours");
        restrict_access(&file);
        assert_eq!(file.metadata().expect("there").mode() & 0o777, 0o600);
    }
}
