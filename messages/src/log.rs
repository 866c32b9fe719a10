//! Words for people.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Writes a line to standard error, [`printable`]. That nobody reads it, or that it cannot be written, must not end a run: `eprintln!`
/// would.
pub fn log(words: impl Display) {
    let _ = writeln!(stderr(), "{}", printable(&words.to_string()));
}

/// Text in which control characters, such as the escapes that steer a terminal, are shown and not obeyed.
pub fn printable(text: &str) -> String {
    let shown = |character: char| match character.is_control() && !matches!(character, '\t' | '\n') {
        true => character.escape_default().to_string(),
        false => character.to_string(),
    };
    text.chars().map(shown).collect()
}
