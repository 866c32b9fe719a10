//! Messages on standard error.

use std::fmt::Display;
use std::io::{Write, stderr};

/// Writes a line to standard error, with control characters escaped. If the line cannot be written, the run goes on; `eprintln!` would
/// end it by a panic.
pub fn log(message: impl Display) {
    let _ = writeln!(stderr(), "{}", printable(&message.to_string()));
}

/// Digits that the plain form of a number may have more than its scientific form.
const PLAIN_DIGITS: usize = 6;

/// A number as a person would write it: 0.000001 and 1000000, but 1e-9 and 1e30, which have hundreds of digits in the worst case.
pub fn legible(number: f64) -> String {
    let (plain, scientific) = (number.to_string(), format!("{number:e}"));
    if plain.len() > scientific.len() + PLAIN_DIGITS { scientific } else { plain }
}

/// Text in which control characters are escaped, so that a name can neither send commands to the terminal nor change the order in which its
/// characters are shown.
pub fn printable(text: &str) -> String {
    let shown = |character: char| match is_hidden(character) {
        true => character.escape_default().to_string(),
        false => character.to_string(),
    };
    text.chars().map(shown).collect()
}

/// Whether a character has an effect instead of a shape. Bidirectional controls show later characters in another order (Unicode Annex 9).
fn is_hidden(character: char) -> bool {
    let bidirectional =
        matches!(character, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}');
    bidirectional || character.is_control() && !matches!(character, '\t' | '\n')
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_cannot_command_the_terminal_or_reorder_a_line() {
        assert_eq!(printable("a\u{1b}[2J\u{202e}gpj.exe\u{2066}"), "a\\u{1b}[2J\\u{202e}gpj.exe\\u{2066}");
        assert_eq!(printable("naïve 歩行 שלום\tand\n"), "naïve 歩行 שלום\tand\n");
    }

    #[test]
    fn numbers_have_no_long_rows_of_zeros() {
        let numbers = [0.0, -1.5, 0.000001, 1e6, 1e9, 1e-9, 1e300, -5e-324, 0.1 + 0.2, f64::NAN, f64::INFINITY];
        let shown = numbers.map(legible);
        let right = [
            "0",
            "-1.5",
            "0.000001",
            "1000000",
            "1e9",
            "1e-9",
            "1e300",
            "-5e-324",
            "0.30000000000000004",
            "NaN",
            "inf",
        ];
        assert_eq!(shown, right);
    }
}
