//! What a child process writes to its standard error: shown line by line as it comes. Neither bytes that are no text, nor long
//! lines, nor many of them can do harm: a line is cut, and only the last error is kept.

use shared::output::printable;
use std::io::{self, BufRead, BufReader, Read};
use std::thread::JoinHandle;

/// The rest of a longer line is dropped [bytes]. A terminal has lines of 80 to 300.
const LONGEST_LINE: usize = 1000;
/// Of a text that is kept whole [bytes].
const LONGEST_TEXT: u64 = 1 << 16;
/// So many lines of an error are kept for the sentence at the end: a refusal has up to six. Further ones are shown.
const KEPT: usize = 20;

/// Whose program a child is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Author {
    /// A role of this program. Its error is its last word, and is told at the end, by whoever started it.
    Ours,
    /// Somebody else. All lines are shown at once; what they say of the end is told again in one line.
    Foreign,
}

/// Reads until the child closes it; returns the lines of its last error.
pub fn listen(
    stderr: impl Read + Send + 'static,
    author: Author,
    show: impl Fn(&str) + Send + 'static,
) -> JoinHandle<Vec<String>> {
    std::thread::spawn(move || {
        let mut stderr = BufReader::new(stderr);
        let mut error: Vec<String> = Vec::new();
        let mut last = String::new();
        while let Ok(Some(line)) = next_line(&mut stderr) {
            let begins = line.starts_with("error: ") || is_a_crash(&line);
            if begins && author == Author::Foreign {
                error.clear();
            }
            // An error may have more lines, such as the caret under a word.
            let kept = (begins || !error.is_empty()) && error.len() < KEPT;
            if !kept || author == Author::Foreign {
                show(&line);
            }
            if kept {
                error.push(line.strip_prefix("error: ").unwrap_or(&line).into());
            }
            last = line;
        }
        match author {
            Author::Ours => error,
            Author::Foreign => gist(&error, last).into_iter().collect(),
        }
    })
}

/// Reads until the child closes it; returns what fits on a few pages.
pub fn hear(stderr: impl Read) -> String {
    let (mut stderr, mut bytes) = (stderr, Vec::new());
    // Until the child ends: what nobody reads any more would block or kill it.
    let _ =
        stderr.by_ref().take(LONGEST_TEXT).read_to_end(&mut bytes).and_then(|_| io::copy(&mut stderr, &mut io::sink()));
    String::from_utf8_lossy(&bytes).into_owned()
}

/// The line that says most: of a Python exception the last one, of a panic the one after its place, else the first.
fn gist(error: &[String], last: String) -> Option<String> {
    match error.first()? {
        first if first.starts_with("Traceback ") => Some(last),
        first if is_a_crash(first) => error.get(1).or(Some(first)).cloned(),
        first => Some(first.clone()),
    }
}

/// The first line of a panic, or of what Python says when it ends by an exception.
fn is_a_crash(line: &str) -> bool {
    line.starts_with("thread '") || line.starts_with("Traceback ")
}

/// The next line without its end, cut and printable; nothing after the last.
fn next_line(input: &mut impl BufRead) -> io::Result<Option<String>> {
    let mut bytes = Vec::new();
    input.by_ref().take(LONGEST_LINE as u64).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    let ended = bytes.last() == Some(&b'\n');
    let is_cut = !ended && bytes.len() == LONGEST_LINE;
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

    /// What is shown and what is kept of this.
    fn heard(author: Author, text: &'static [u8]) -> (Vec<String>, Vec<String>) {
        let shown = Arc::new(Mutex::new(Vec::new()));
        let lines = shown.clone();
        let kept = listen(text, author, move |line| lines.lock().expect("no panic").push(line.into()));
        let kept = kept.join().expect("no panic");
        (Arc::into_inner(shown).expect("the last").into_inner().expect("no panic"), kept)
    }

    #[test]
    fn bytes_that_are_no_text_and_escapes_are_shown_as_such() {
        let (shown, kept) = heard(Author::Foreign, b"one\n\xff\xfe two \x1b[2J\nthree");
        assert_eq!(shown, ["one", "\u{fffd}\u{fffd} two \\u{1b}[2J", "three"]);
        assert!(kept.is_empty());
    }

    #[test]
    fn after_an_error_of_somebody_elses_program_all_is_shown_still_and_the_last_error_is_kept() {
        let (shown, kept) = heard(Author::Foreign, b"error: one\nmore\nerror: two\nand more\n");
        assert_eq!(shown, ["error: one", "more", "error: two", "and more"]);
        assert_eq!(kept, ["two"]);
        let (_, kept) = heard(Author::Foreign, b"Traceback (most recent call last):\n  File x\nValueError: no legs\n");
        assert_eq!(kept, ["ValueError: no legs"]);
        let (_, kept) = heard(Author::Foreign, b"thread 'main' panicked at x.rs:1:1:\nno legs\nnote: run with\n");
        assert_eq!(kept, ["no legs"]);
    }

    #[test]
    fn of_ours_the_error_is_kept_whole_but_never_more_than_a_page() {
        let (shown, kept) = heard(Author::Ours, b"warm\nerror: one\n  ^\n");
        assert_eq!((shown, kept), (vec!["warm".into()], vec!["one".to_string(), "  ^".into()]));
        let many = "error: one\n".to_string() + &"more\n".repeat(100);
        let (shown, kept) = heard(Author::Ours, many.leak().as_bytes());
        assert_eq!((shown.len(), kept.len()), (101 - KEPT, KEPT));
    }

    #[test]
    fn a_long_text_that_is_none_is_read_to_its_end() {
        let mut endless = io::repeat(0xff).take(1 << 28);
        assert!(hear(&mut endless).starts_with("\u{fffd}"));
        assert_eq!(endless.limit(), 0);
    }

    #[test]
    fn a_line_without_an_end_is_cut_and_takes_no_memory() {
        let endless = io::repeat(b'x').take(1 << 30).chain(&b"\nlast\n"[..]);
        let mut input = BufReader::new(endless);
        let line = next_line(&mut input).expect("no fault").expect("a line");
        assert_eq!(line.chars().count(), LONGEST_LINE + 2);
        assert_eq!(next_line(&mut input).expect("no fault").as_deref(), Some("last"));
    }
}
