//! The layout of the documents, which no reader should have to think about.

use crate::commands::documents;

/// Longest line of prose; tables, pictures and output may be longer.
const LONGEST: usize = 160;

/// The numbered lines of a document that are prose: outside blocks, tables and pictures.
fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut is_block = false;
    text.lines().enumerate().filter_map(move |(nr, line)| {
        let fence = line.trim_start().starts_with("```");
        is_block ^= fence;
        (!is_block && !fence && !line.starts_with(['|', '<']) && !line.starts_with("    ")).then_some((nr + 1, line))
    })
}

/// Whether a line has a number below one without its zero, outside code.
fn lacks_zero(line: &str) -> bool {
    line.split('`').step_by(2).any(|words| {
        let characters: Vec<char> = words.chars().collect();
        let is_open =
            |at: usize| at == 0 || !(characters[at - 1].is_alphanumeric() || "./…_".contains(characters[at - 1]));
        (1..characters.len()).any(|at| characters[at].is_ascii_digit() && characters[at - 1] == '.' && is_open(at - 1))
    })
}

#[test]
fn no_line_of_prose_is_too_long_and_numbers_below_one_have_a_zero_except_in_the_notes() {
    let mut lines = 0;
    for (document, text) in documents() {
        let is_user_document = document.parent().is_some_and(|folder| folder.ends_with("docs"));
        for (nr, line) in prose(&text) {
            let place = format!("{}:{nr}: {line}", document.display());
            assert!(line.chars().count() <= LONGEST, "{place}");
            assert!(!is_user_document || !lacks_zero(line), "{place}");
            lines += 1;
        }
    }
    assert!(lines > 1500, "{lines}");
    assert!(lacks_zero("at .2 m/s") && lacks_zero("(−.5)") && !lacks_zero("0.2, 1.5, `.2`, v1.2.3, step.rs"));
}
