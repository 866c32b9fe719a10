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

/// Digits of a bound in an error.
const BOUND_DIGITS: i32 = 3;

/// The greatest number of three digits up to a bound: an error that names it names a number that is itself accepted.
pub fn rounded_down(bound: f64) -> f64 {
    rounded(bound, f64::floor)
}

/// The least number of three digits from a bound on. See [`rounded_down`].
pub fn rounded_up(bound: f64) -> f64 {
    rounded(bound, f64::ceil)
}

/// A number with three digits. One that differs from such a number by the rounding of its own computation counts as that number.
fn rounded(bound: f64, direction: fn(f64) -> f64) -> f64 {
    let exponent = format!("{bound:e}").split_once('e').and_then(|(_, exponent)| exponent.parse().ok()).unwrap_or(0);
    let unit = exponent + 1 - BOUND_DIGITS;
    let digits = bound / 10f64.powi(unit);
    let near = digits.round();
    let is_near = (digits - near).abs() <= 8.0 * f64::EPSILON * near.abs();
    format!("{}e{unit}", if is_near { near } else { direction(digits) }).parse().unwrap_or(bound)
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
    fn a_bound_is_rounded_inward_to_three_digits() {
        for (bound, down, up) in [
            (5.0 / 9.0, 0.555, 0.556),
            (0.1 + 0.2, 0.3, 0.3), // 0.30000000000000004
            (0.25, 0.25, 0.25),
            (std::f64::consts::PI * 1e3, 3140.0, 3150.0),
            (9.9999, 9.99, 10.0),
            (1.2345e-7, 1.23e-7, 1.24e-7),
            (-1.2345, -1.24, -1.23),
            (0.0, 0.0, 0.0),
        ] {
            assert_eq!([rounded_down(bound), rounded_up(bound)], [down, up], "{bound}");
        }
        assert!(rounded_down(f64::INFINITY) == f64::INFINITY && rounded_up(f64::NAN).is_nan());
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
