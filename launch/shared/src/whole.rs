//! Files that are written whole or not at all, and never over a file that this program did not write.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process;

/// What pages and drawings of ours begin with.
pub const MARK: &str = "<!-- biped -->\n";
/// By so many first bytes a file is known to be ours.
const HEAD: usize = 12;

/// Writes beside the file and renames, so that no reader ever sees half of it. Pages and drawings get our [`MARK`].
///
/// # Errors
/// As the file system has them, with the file's name; or if a file is there that begins otherwise. Nothing is left of the half.
pub fn write_whole(path: &Path, text: &str) -> io::Result<()> {
    let mark = if path.extension().is_some_and(|kind| kind == "svg" || kind == "html") { MARK } else { "" };
    let head = if mark.is_empty() { text } else { mark };
    let written = Draft::of(path, head.as_bytes()).and_then(|mut draft| {
        draft.file.write_all(mark.as_bytes())?;
        draft.file.write_all(text.as_bytes())?;
        draft.keep()
    });
    written.map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", path.display())))
}

/// A file beside the one that it will replace. It goes if it is not kept.
pub struct Draft {
    /// Where it is written.
    pub file: File,
    here: PathBuf,
    there: PathBuf,
}

impl Draft {
    /// In the place of nothing, or of a file that begins as this one does.
    ///
    /// # Errors
    /// As the file system has them; or if something else is there.
    pub fn of(path: &Path, head: &[u8]) -> io::Result<Draft> {
        replaces(path, head)?;
        let there = path.canonicalize().unwrap_or_else(|_| path.into()); // a link stays
        let name = there.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut number = 0;
        loop {
            let here = there.with_file_name(format!(".{name}.{}-{number}.part", process::id()));
            match File::options().read(true).write(true).create_new(true).open(&here) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
                file => return Ok(Draft { file: file?, here, there }),
            }
        }
    }

    /// Puts it in its place.
    ///
    /// # Errors
    /// As the file system has them.
    pub fn keep(self) -> io::Result<()> {
        fs::rename(&self.here, &self.there)
    }
}

impl Drop for Draft {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.here); // it may be in its place
    }
}

/// Whether nothing would be lost there: no file is there, an empty one, or one that begins so, as those of this program do.
///
/// # Errors
/// If it would, or the file cannot be read.
pub fn replaces(path: &Path, head: &[u8]) -> io::Result<()> {
    let head = &head[..head.len().min(HEAD)];
    match messages::file::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        file => {
            let mut begin = vec![];
            file?.take(HEAD as u64).read_to_end(&mut begin)?;
            let is_ours = begin.starts_with(head) || head.starts_with(&begin); // also a beginning that was cut short
            let words = "it is there and `biped` did not write it, so it is kept: name another place";
            if is_ours { Ok(()) } else { Err(io::Error::new(ErrorKind::AlreadyExists, words)) }
        }
    }
}

/// Removes the drawings of this program from a folder, and nothing else.
///
/// # Errors
/// As the file system has them.
pub fn remove_drawings(folder: &Path) -> io::Result<()> {
    for file in fs::read_dir(folder)?.flatten().map(|entry| entry.path()) {
        let is_drawing = file.extension().is_some_and(|kind| kind == "svg");
        if is_drawing && fs::metadata(&file)?.len() > 0 && replaces(&file, MARK.as_bytes()).is_ok() {
            fs::remove_file(file)?;
        }
    }
    Ok(())
}
