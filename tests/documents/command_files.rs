//! The files and the tests that a command in a document names exist.

use crate::commands::{documents, pieces};
use crate::{code_of, files};
use std::path::Path;

#[test]
fn every_file_in_a_command_of_a_document_exists() {
    let folders = ["controller/", "plant/", "launch/", "messages/", "tests/", "docs/", "examples/", ".ci/"];
    let mut checked = 0;
    for (document, text) in documents() {
        for piece in pieces(&text).iter().filter(|piece| piece.contains(' ')) {
            for word in piece.split(|c: char| c.is_whitespace() || "\"'=`();,".contains(c)) {
                if folders.iter().any(|folder| word.starts_with(folder)) && !word.contains(['*', '…']) {
                    assert!(
                        Path::new(env!("CARGO_MANIFEST_DIR")).join(word).exists(),
                        "{}: {word}",
                        document.display()
                    );
                    checked += 1;
                }
            }
        }
    }
    assert!(checked > 20, "only {checked} files were found");
}

/// The sources of a test: one file or a folder, of the program or of a crate.
fn sources_of_test(words: &[&str], name: &str) -> String {
    let package = words.iter().skip_while(|word| **word != "-p").nth(1);
    let folder = package.map_or("tests".into(), |package| format!("{}/tests", package.trim_start_matches("biped-")));
    let paths = files(&folder, "rs").into_iter().filter(|path| {
        path.ends_with(format!("tests/{name}.rs")) || path.components().any(|part| part.as_os_str() == name)
    });
    code_of(paths)
}

#[test]
fn every_test_that_a_command_of_a_document_runs_exists() {
    let mut checked = 0;
    for (document, text) in documents() {
        for piece in pieces(&text) {
            let words: Vec<&str> = piece.split_whitespace().collect();
            let Some(place) = words.iter().position(|word| *word == "--test") else {
                continue;
            };
            let Some(name) = words.get(place + 1) else { continue };
            let sources = sources_of_test(&words, name);
            assert!(!sources.is_empty(), "{}: there is no test `{name}`: {piece}", document.display());
            let filter = words.get(place + 2).filter(|word| !word.starts_with('-')).unwrap_or(&"");
            let named = |line: &str| {
                line.trim_start().starts_with("fn ") && line.contains(filter)
                    || line.contains("mod ") && line.contains(filter)
            };
            assert!(sources.lines().any(named), "{}: `{name}` has no test `{filter}`: {piece}", document.display());
            checked += 1;
        }
    }
    assert!(checked > 10, "only {checked} commands were found");
}
