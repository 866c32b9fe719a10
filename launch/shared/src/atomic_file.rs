//! Atomic output files: a file is written completely or not at all, and never replaces a file of another program.

use std::fs::{self, File};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::process;

/// First line of every page and figure that this program writes.
pub const MARK: &str = "<!-- biped -->\n";
/// First bytes of a recording, which is an MCAP file.
const RECORDING: &[u8] = b"\x89MCAP0\r\n";
/// Number of leading bytes by which this program recognizes its own files [bytes].
const SIGNATURE_BYTES: usize = 12;

/// Writes a text file atomically, through a temporary file beside it and a rename. A drawing or page, in SVG or HTML, gets [`MARK`] as its
/// first line, whatever the file is called: its own beginning is that of any other page.
///
/// # Errors
/// An error of the file system, with the file's name; or a file at this path that begins differently. The temporary file is
/// removed in both cases.
pub fn write_atomically(path: &Path, text: &str) -> io::Result<()> {
    let mark = if text.starts_with('<') { MARK } else { "" };
    let signature = if mark.is_empty() { text } else { mark };
    let written = AtomicFile::create(path, signature.as_bytes()).and_then(|mut output| {
        output.file.write_all(mark.as_bytes())?;
        output.file.write_all(text.as_bytes())?;
        output.commit()
    });
    written.map_err(|error| io::Error::new(error.kind(), format!("{}: {error}", path.display())))
}

/// A temporary file that replaces its target on [`AtomicFile::commit`]. Dropped without that, it is removed.
pub struct AtomicFile {
    /// The open temporary file.
    pub file: File,
    temporary: PathBuf,
    target: PathBuf,
}

impl AtomicFile {
    /// Creates the temporary file beside the target. The target may be missing, or begin with this signature.
    ///
    /// # Errors
    /// An error of the file system, or a target that is a file of another program.
    pub fn create(path: &Path, signature: &[u8]) -> io::Result<AtomicFile> {
        check_replaceable(path, signature)?;
        let target = path.canonicalize().unwrap_or_else(|_| path.into()); // a symbolic link stays a link
        let name = target.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let mut number = 0;
        loop {
            let temporary = target.with_file_name(format!(".{name}.{}-{number}.part", process::id()));
            match File::options().read(true).write(true).create_new(true).open(&temporary) {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => number += 1,
                file => return Ok(AtomicFile { file: file?, temporary, target }),
            }
        }
    }

    /// Renames the temporary file to the target.
    ///
    /// # Errors
    /// An error of the file system.
    pub fn commit(self) -> io::Result<()> {
        fs::rename(&self.temporary, &self.target)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        let _ = fs::remove_file(&self.temporary); // fails after a commit, which has renamed it
    }
}

/// Checks that a path can be overwritten without loss: it is missing, empty, or begins with this signature.
///
/// # Errors
/// If the file begins differently or cannot be read.
pub fn check_replaceable(path: &Path, signature: &[u8]) -> io::Result<()> {
    let signature = &signature[..signature.len().min(SIGNATURE_BYTES)];
    match messages::file::open(path) {
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(()),
        file => {
            let mut begin = vec![];
            file?.take(SIGNATURE_BYTES as u64).read_to_end(&mut begin)?;
            let is_ours = begin.starts_with(signature) || signature.starts_with(&begin); // a truncated file of ours is shorter
            let what =
                if begin.starts_with(RECORDING) { "is a recording" } else { "is not one that this command writes" };
            let words = format!("the file exists and {what}; it is kept: choose another path");
            if is_ours { Ok(()) } else { Err(io::Error::new(ErrorKind::AlreadyExists, words)) }
        }
    }
}

/// Removes the SVG figures of this program from a folder. All other files stay.
///
/// # Errors
/// An error of the file system.
pub fn remove_own_figures(folder: &Path) -> io::Result<()> {
    for file in fs::read_dir(folder)?.flatten().map(|entry| entry.path()) {
        let is_figure = file.extension().is_some_and(|kind| kind == "svg");
        if is_figure && fs::metadata(&file)?.len() > 0 && check_replaceable(&file, MARK.as_bytes()).is_ok() {
            fs::remove_file(file)?;
        }
    }
    Ok(())
}
