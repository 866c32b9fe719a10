//! Standard output, error messages, and the checks before a file is written.

pub use crate::atomic_file::{AtomicFile, MARK, check_replaceable, remove_own_figures, write_atomically};
use crate::exit::{Exit, Failure};
pub use messages::{log, printable};
use nix::unistd::mkdtemp;
use std::fs::{self, File, TryLockError};
use std::io::{self, ErrorKind, Write};
use std::path::{Path, PathBuf};
use std::process;

/// Longest line of an error message [characters]. A sentence of this program with a path in it has up to 300.
const MAX_LINE_CHARS: usize = 400;
/// Most lines of an error message. An excerpt of a file has 6, the error of a child process up to 20.
const MAX_LINES: usize = 30;

/// Writes text to standard output. Control characters are escaped, because names in the text may come from foreign files.
///
/// A closed pipe, such as that of `head`, is no error. Any other write error, such as a full disk, ends the program.
pub fn print_text(text: impl std::fmt::Display) {
    let mut out = io::stdout();
    match write!(out, "{}", printable(&text.to_string())).and_then(|()| out.flush()) {
        Err(error) if error.kind() != ErrorKind::BrokenPipe => {
            log(format_args!("error: standard output cannot be written: {error}"));
            process::exit(Exit::Fault as i32);
        }
        _ => (),
    }
}

/// Makes an error message safe to print: it escapes control characters, cuts long lines in the middle, and drops lines beyond
/// [`MAX_LINES`].
pub fn shortened(message: &str) -> String {
    let mut lines: Vec<String> = message.lines().take(MAX_LINES).map(|line| shortened_line(&printable(line))).collect();
    if message.lines().count() > MAX_LINES {
        lines.push("…".into());
    }
    lines.join("\n")
}

fn shortened_line(line: &str) -> String {
    let length = line.chars().count();
    let part = |from, count| line.chars().skip(from).take(count).collect::<String>();
    let half = MAX_LINE_CHARS / 2;
    if length <= MAX_LINE_CHARS {
        return line.into();
    }
    let (begin, end) = (part(0, half), part(length - half, half));
    // whole words, unless a single word is as long as that
    let begin = begin.rsplit_once(' ').filter(|(begin, _)| begin.len() > half / 2).map_or(&*begin, |(begin, _)| begin);
    let end = end.split_once(' ').filter(|(_, end)| end.len() > half / 2).map_or(&*end, |(_, end)| end);
    format!("{begin} … {end}")
}

/// Creates an output folder. Commands call this before the work, so that a bad path is reported at once.
///
/// # Errors
/// If the folder cannot be created.
pub fn create_folder(path: &Path) -> Result<(), Failure> {
    fs::create_dir_all(path).map_err(|error| match error.kind() {
        ErrorKind::AlreadyExists => {
            Failure::new(Exit::Usage, format!("{} is not a folder: choose another path", path.display()))
        }
        _ => write_failure(path, &error),
    })
}

/// Creates an output folder, and checks that each of these files can be replaced: it is missing, or begins with the given text.
/// Commands call this before the work, so that a file of the user is refused at once.
///
/// # Errors
/// If the folder cannot be created, or has a file of another program.
pub fn prepare_folder(path: &Path, files: &[(impl AsRef<Path>, &str)]) -> Result<(), Failure> {
    create_folder(path)?;
    files.iter().try_for_each(|(name, begin)| {
        let file = path.join(name);
        check_replaceable(&file, begin.as_bytes())
            .map_err(|error| Failure::new(Exit::Usage, format!("{}: {error}", file.display())))
    })
}

/// Creates a temporary folder that only this user can access, with an unpredictable name. The caller removes it.
///
/// # Errors
/// If the folder cannot be created.
pub fn temporary_folder(purpose: &str) -> Result<PathBuf, Failure> {
    let folder = std::env::temp_dir().join(format!("biped-{purpose}-XXXXXX"));
    mkdtemp(&folder).map_err(|error| write_failure(&folder, &error))
}

/// The failure that reports a file or folder that cannot be written. The error may begin with its path too.
pub fn write_failure(path: &Path, error: &impl std::fmt::Display) -> Failure {
    let (path, error) = (path.display().to_string(), error.to_string());
    let reason = error.strip_prefix(&format!("{path}: ")).unwrap_or(&error);
    Failure::new(Exit::Fault, format!("{path} cannot be written: {reason}"))
}

/// The failure that reports an output file that cannot be begun. A file of another kind at its path is a wrong argument.
pub fn create_failure(path: &Path, error: &std::io::Error) -> Failure {
    let failure = write_failure(path, error);
    match error.kind() {
        ErrorKind::AlreadyExists => Failure::new(Exit::Usage, failure.message),
        _ => failure,
    }
}

/// Takes an exclusive lock on an output file.
///
/// # Errors
/// If another process holds the lock; `message` then says what to do.
pub fn lock_for_writing(file: &File, message: impl FnOnce() -> String) -> Result<(), Failure> {
    match file.try_lock() {
        Err(TryLockError::WouldBlock) => Err(Failure::new(Exit::Usage, message())),
        _ => Ok(()), // some file systems have no locks: there the file is written without one
    }
}

/// Refuses an output path that is the input file.
///
/// # Errors
/// If both paths name the same file.
pub fn refuse_overwriting_input(input: &Path, output: &Path) -> Result<(), Failure> {
    let same = input.canonicalize().is_ok_and(|input| output.canonicalize().is_ok_and(|output| input == output));
    match same {
        true => {
            Err(Failure::new(Exit::Usage, format!("{} is the input file: write to another file", output.display())))
        }
        false => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::fs::PermissionsExt;

    #[test]
    fn temporary_folders_are_private_and_their_names_differ() {
        let folders = [(); 2].map(|()| temporary_folder("test").expect("a folder"));
        assert_ne!(folders[0], folders[1]);
        for folder in folders {
            assert_eq!(folder.metadata().expect("its mode").permissions().mode() & 0o777, 0o700);
            fs::remove_dir(folder).expect("our own");
        }
    }

    #[test]
    fn error_messages_are_escaped_and_shortened() {
        assert_eq!(shortened("no scene `\u{1b}[31mred\u{7}`"), "no scene `\\u{1b}[31mred\\u{7}`");
        let long = shortened(&format!("first {} last", "x".repeat(100_000)));
        assert!(long.starts_with("first ") && long.ends_with(" last") && long.chars().count() == MAX_LINE_CHARS + 3);
        let names = shortened(&"`left_foot`, ".repeat(1000));
        assert!(
            names.len() > MAX_LINE_CHARS / 2 && names.split(' ').all(|name| ["`left_foot`,", "…", ""].contains(&name)),
            "{names}"
        );
        let lines = shortened(&"line\n".repeat(1000));
        assert_eq!(lines.lines().count(), MAX_LINES + 1);
    }
}
