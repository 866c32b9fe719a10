//! What is written: to the terminal, and into files, each whole or not at all, and none over what somebody else wrote.

use crate::exit::{Exit, Failure};
pub use messages::{log as tell, printable};
use std::fs::{File, TryLockError};
use std::io::{self, ErrorKind, Read, Write};
use std::path::{Path, PathBuf};
use std::{fs, process};

/// Characters of a line of an error message: a sentence of this program with a path in it has up to 300.
const LONGEST_LINE: usize = 400;
/// Lines of an error message: an excerpt of a file has six, a child's last words up to twenty.
const MOST_LINES: usize = 30;

/// What pages and drawings of ours begin with.
pub const MARK: &str = "<!-- biped -->\n";
/// By so many first bytes a file is known to be ours.
const HEAD: usize = 12;

/// Prints, [`printable`], for names come from anybody; a reader that has had enough, such as `head`, is no error, a full disk ends the program.
pub fn say(text: impl std::fmt::Display) {
    let mut out = io::stdout();
    match write!(out, "{}", printable(&text.to_string())).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            tell(format_args!("error: what is printed cannot be written: {error}"));
            process::exit(Exit::Fault as i32);
        }
        _ => (),
    }
}

/// A message in which names and excerpts, which come from anybody's file, are printable, and no line is longer than [`LONGEST_LINE`]:
/// the middle is left out.
pub fn brief(message: &str) -> String {
    let mut lines: Vec<String> = message.lines().take(MOST_LINES).map(|line| cut(&printable(line))).collect();
    if message.lines().count() > MOST_LINES {
        lines.push("…".into());
    }
    lines.join("\n")
}

fn cut(line: &str) -> String {
    let length = line.chars().count();
    let part = |from, count| line.chars().skip(from).take(count).collect::<String>();
    let half = LONGEST_LINE / 2;
    if length <= LONGEST_LINE { line.into() } else { format!("{} … {}", part(0, half), part(length - half, half)) }
}

/// Makes a folder for what will be written, before the work and not after it.
///
/// # Errors
/// If that is not possible.
pub fn folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| unwritten(path, &error))
}

/// A failure about what was to be written.
pub fn unwritten(path: &Path, error: &impl std::fmt::Display) -> Failure {
    Failure::new(Exit::Fault, format!("{} cannot be written: {error}", path.display()))
}

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

/// Locks a file that is to be written, or refuses, in these words, what somebody else is writing.
///
/// # Errors
/// That.
pub fn alone(file: &File, taken: impl FnOnce() -> String) -> Result<(), Failure> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Failure::new(Exit::Usage, taken())),
        _ => Ok(()), // nor is there a lock where the file system has none
    }
}

/// Refuses to write into the file that is read.
///
/// # Errors
/// That.
pub fn keeps(input: &Path, output: &Path) -> Result<(), Failure> {
    let same = input.canonicalize().is_ok_and(|input| output.canonicalize().is_ok_and(|output| input == output));
    match same {
        true => {
            Err(Failure::new(Exit::Usage, format!("{} is what is read: write into another file", output.display())))
        }
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_message_shows_escapes_and_is_cut_in_the_middle() {
        assert_eq!(brief("no scene `\u{1b}[31mred\u{7}`"), "no scene `\\u{1b}[31mred\\u{7}`");
        let long = brief(&format!("first {} last", "x".repeat(100_000)));
        assert!(long.starts_with("first ") && long.ends_with(" last") && long.chars().count() == LONGEST_LINE + 3);
        let lines = brief(&"line\n".repeat(1000));
        assert_eq!(lines.lines().count(), MOST_LINES + 1);
    }
}
