//! The arguments of the command line.

use crate::exit::Exit;
use clap::error::ErrorKind;
use clap::{ArgMatches, Command};
use shared::output::{log, shortened};
use std::error::Error;
use std::ffi::OsString;
use std::num::{IntErrorKind, ParseFloatError, ParseIntError};
use std::os::unix::ffi::OsStrExt;

/// The character that replaces bytes which are not UTF-8 text.
const REPLACEMENT: char = '\u{fffd}';

/// Parses the arguments, or ends the program. A path may have any bytes. All other arguments must be text.
pub fn matches(command: Command) -> ArgMatches {
    command.try_get_matches().unwrap_or_else(|error| {
        if std::env::args_os().any(|one| one.to_string_lossy().contains(char::is_control)) && error.use_stderr() {
            log(shortened(error.render().to_string().trim_end())); // the error quotes the argument
            std::process::exit(Exit::Usage as i32)
        }
        let is_about_bytes = error.kind() == ErrorKind::InvalidUtf8 || error.to_string().contains(REPLACEMENT);
        let bad: Vec<String> = std::env::args_os().skip(1).filter(|one| one.to_str().is_none()).map(escaped).collect();
        if !is_about_bytes || bad.is_empty() {
            let Some((rust, words)) = number(&error) else { error.exit() };
            log(error.render().to_string().trim_end().replace(&rust, &words));
            std::process::exit(Exit::Usage as i32)
        }
        let words = format!("error: an argument must be UTF-8 text, and this is not: {}", bad.join(" "));
        log(shortened(&words));
        std::process::exit(Exit::Usage as i32)
    })
}

/// Rust's own message about a value that is no number or out of range, and the message that replaces it.
fn number(error: &clap::Error) -> Option<(String, String)> {
    let source = error.source()?;
    let text = source.to_string();
    let words = match source.downcast_ref::<ParseIntError>().map(ParseIntError::kind) {
        Some(IntErrorKind::PosOverflow) => "a smaller number is needed".into(),
        Some(_) => "a whole number of 0 or more is needed".into(),
        None if source.is::<ParseFloatError>() => "a number is needed, such as 0.5".into(),
        None => {
            let (least, most) = text.split_once(" is not in ")?.1.split_once("..")?;
            match most.strip_prefix('=') {
                Some(most) => format!("a whole number from {least} to {most} is needed"),
                None => format!("a whole number of {least} or more is needed"), // up to the end of the type
            }
        }
    };
    Some((text, words))
}

/// The argument as text. Bytes that are not UTF-8 appear as `\xff`.
fn escaped(argument: OsString) -> String {
    let chunks = argument.as_bytes().utf8_chunks();
    chunks.map(|chunk| format!("{}{}", chunk.valid(), chunk.invalid().escape_ascii())).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::os::unix::ffi::OsStringExt;

    #[test]
    fn only_bytes_that_are_no_text_are_escaped() {
        assert_eq!(escaped(OsString::from_vec(b"sc\xc3\xa9ne\xff\xc3.toml".to_vec())), "scéne\\xff\\xc3.toml");
    }
}
