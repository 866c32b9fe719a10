//! Messages on standard error.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Writes a line to standard error, with control characters escaped. If the line cannot be written, the run goes on; `eprintln!` would
/// end it by a panic.
pub fn log(message: impl Display) {
    let _ = writeln!(stderr(), "{}", printable(&message.to_string()));
}

/// Text in which control characters are escaped, so that a name cannot send commands to the terminal.
pub fn printable(text: &str) -> String {
    let shown = |character: char| match character.is_control() && !matches!(character, '\t' | '\n') {
        true => character.escape_default().to_string(),
        false => character.to_string(),
    };
    text.chars().map(shown).collect()
}
