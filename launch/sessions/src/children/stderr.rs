//! Standard error of a child process: forwarded line by line, with the last error kept for the final message. Output of any kind is
//! harmless: invalid UTF-8 is replaced, long lines are cut, and the kept error is bounded.

use shared::exit::Failure;
use shared::output::printable;
use shared::thread;
use std::io::{self, BufRead, BufReader, Read};
use std::thread::JoinHandle;

/// Longest forwarded line; the rest is dropped [bytes]. Terminals show 80 to 300.
const MAX_LINE_BYTES: usize = 1000;
/// Longest text that [`read_stderr`] returns [bytes].
const MAX_TEXT_BYTES: u64 = 1 << 16;
/// Most lines of an error that are kept for the final message; further lines are forwarded. Errors of this program have up to 6.
const MAX_ERROR_LINES: usize = 20;

/// Whether a child is this program or a foreign one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Origin {
    /// This program in another role. Its error is its last output; it is not forwarded, but becomes part of the final message.
    Own,
    /// A foreign program. All lines are forwarded; the key line of its last error becomes part of the final message too.
    Foreign,
}

/// Reads standard error in a thread until the child closes it, and forwards lines to `show`. The thread returns the lines of the last
/// error.
///
/// # Errors
/// If the thread cannot be started.
pub fn forward(
    stderr: impl Read + Send + 'static,
    origin: Origin,
    show: impl Fn(&str) + Send + 'static,
) -> Result<JoinHandle<Vec<String>>, Failure> {
    thread::start(move || {
        let mut stderr = BufReader::new(stderr);
        let mut error: Vec<String> = Vec::new();
        let mut last = String::new();
        while let Ok(Some(line)) = next_line(&mut stderr) {
            let is_error_start = line.starts_with("error: ") || is_crash_header(&line);
            if is_error_start && origin == Origin::Foreign {
                error.clear();
            }
            // An error may have several lines, for example an excerpt of a file.
            let is_kept = (is_error_start || !error.is_empty()) && error.len() < MAX_ERROR_LINES;
            if !is_kept || origin == Origin::Foreign {
                show(&line);
            }
            if is_kept {
                error.push(line.strip_prefix("error: ").unwrap_or(&line).into());
            }
            last = line;
        }
        match origin {
            Origin::Own => error,
            Origin::Foreign => key_line(&error, last).into_iter().collect(),
        }
    })
}

/// Reads standard error until the child closes it, and returns its first [`MAX_TEXT_BYTES`].
pub fn read_stderr(stderr: impl Read) -> String {
    let (mut stderr, mut bytes) = (stderr, Vec::new());
    // The rest is read too: a full or closed pipe would block or kill the child.
    let _ = stderr
        .by_ref()
        .take(MAX_TEXT_BYTES)
        .read_to_end(&mut bytes)
        .and_then(|_| io::copy(&mut stderr, &mut io::sink()));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The most informative line of an error: the last one of a Python exception, the second one of a panic, otherwise the first one.
fn key_line(error: &[String], last: String) -> Option<String> {
    match error.first()? {
        first if first.starts_with("Traceback ") => Some(last),
        first if is_crash_header(first) => error.get(1).or(Some(first)).cloned(),
        first => Some(first.clone()),
    }
}

/// Whether a line begins the message of a Rust panic or of an uncaught Python exception.
fn is_crash_header(line: &str) -> bool {
    line.starts_with("thread '") || line.starts_with("Traceback ")
}

/// The next line without its line end, cut and printable; `None` at the end.
fn next_line(input: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    input.by_ref().take(MAX_LINE_BYTES as u64).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    let ended = bytes.last() == Some(&b'\n');
    let is_cut = !ended && bytes.len() == MAX_LINE_BYTES;
    if is_cut {
        input.skip_until(b'\n')?;
    }
    let text = String::from_utf8_lossy(&bytes);
    Ok(Some(printable(text.trim_end_matches(['\n', '\r'])) + if is_cut { " …" } else { "" }))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};

    /// Forwards a text; returns the lines that are shown and those that are kept.
    fn forwarded(origin: Origin, text: &'static [u8]) -> (Vec<String>, Vec<String>) {
        let shown = Arc::new(Mutex::new(Vec::new()));
        let lines = shown.clone();
        let kept = forward(text, origin, move |line| lines.lock().expect("no panic").push(line.into()));
        let kept = kept.expect("a thread");
        let kept = kept.join().expect("no panic");
        (Arc::into_inner(shown).expect("the last").into_inner().expect("no panic"), kept)
    }

    #[test]
    fn invalid_utf8_and_control_characters_are_shown_escaped() {
        let (shown, kept) = forwarded(Origin::Foreign, b"one\n\xff\xfe two \x1b[2J\nthree");
        assert_eq!(shown, ["one", "\u{fffd}\u{fffd} two \\u{1b}[2J", "three"]);
        assert!(kept.is_empty());
    }

    #[test]
    fn all_lines_of_a_foreign_program_are_shown_and_its_last_error_is_kept() {
        let (shown, kept) = forwarded(Origin::Foreign, b"error: one\nmore\nerror: two\nand more\n");
        assert_eq!(shown, ["error: one", "more", "error: two", "and more"]);
        assert_eq!(kept, ["two"]);
        let (_, kept) =
            forwarded(Origin::Foreign, b"Traceback (most recent call last):\n  File x\nValueError: no legs\n");
        assert_eq!(kept, ["ValueError: no legs"]);
        let (_, kept) = forwarded(Origin::Foreign, b"thread 'main' panicked at x.rs:1:1:\nno legs\nnote: run with\n");
        assert_eq!(kept, ["no legs"]);
    }

    #[test]
    fn an_error_of_this_program_is_kept_up_to_the_maximal_number_of_lines() {
        let (shown, kept) = forwarded(Origin::Own, b"warm\nerror: one\n  ^\n");
        assert_eq!((shown, kept), (vec!["warm".into()], vec!["one".to_string(), "  ^".into()]));
        let many = "error: one\n".to_string() + &"more\n".repeat(100);
        let (shown, kept) = forwarded(Origin::Own, many.leak().as_bytes());
        assert_eq!((shown.len(), kept.len()), (101 - MAX_ERROR_LINES, MAX_ERROR_LINES));
    }

    #[test]
    fn a_long_text_of_invalid_utf8_is_read_to_its_end() {
        let mut endless = io::repeat(0xff).take(1 << 28);
        assert!(read_stderr(&mut endless).starts_with("\u{fffd}"));
        assert_eq!(endless.limit(), 0);
    }

    #[test]
    fn a_line_without_an_end_is_cut_without_using_memory() {
        let endless = io::repeat(b'x').take(1 << 30).chain(&b"\nlast\n"[..]);
        let mut input = BufReader::new(endless);
        let line = next_line(&mut input).expect("no fault").expect("a line");
        assert_eq!(line.chars().count(), MAX_LINE_BYTES + 2);
        assert_eq!(next_line(&mut input).expect("no fault").as_deref(), Some("last"));
    }
}
