//! Standard output, error messages, and refusals before a file is written.

use crate::exit::{Exit, Failure};
pub use crate::whole::{Draft, MARK, remove_drawings, replaces, write_whole};
pub use messages::{log as tell, printable};
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::Path;
use std::process;

/// Characters of a line of an error message: a sentence of this program with a path in it has up to 300.
const LONGEST_LINE: usize = 400;
/// Lines of an error message: an excerpt of a file has six, a child's last words up to twenty.
const MOST_LINES: usize = 30;

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
