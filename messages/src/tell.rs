//! Words for people.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Writes a line to standard error. That nobody reads it, or that it cannot be written, must not end a run: `eprintln!` would.
pub fn tell(words: impl Display) {
    let _ = writeln!(stderr(), "{words}");
}
