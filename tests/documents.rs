//! Claims about the documents: they show exactly what the program prints.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::Command;

/// Standard output of the program.
fn printed(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).output().expect("the program starts");
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

/// The part of a document between two marks.
fn between<'a>(text: &'a str, start: &str, end: &str) -> &'a str {
    let rest = text.split_once(start).expect(start).1;
    rest.split_once(end).expect(end).0
}

#[test]
fn the_readme_shows_the_summary_of_the_walk() {
    let (shown, printed) =
        (between(include_str!("../README.md"), "```\n", "```"), printed(&["run", "walk", "--quiet"]));
    assert!(shown.lines().count() > 5, "{shown}");
    for line in shown.lines() {
        assert!(printed.lines().any(|printed| printed == line), "`{line}` is not in\n{printed}");
    }
}

#[test]
fn the_paper_document_shows_the_tables_of_the_studies() {
    for study in ["laws", "attraction", "endurance", "margins", "pushes"] {
        let shown = between(include_str!("../docs/PAPER.md"), &format!("<!-- study:{study} -->\n"), "<!-- /study -->");
        let printed = printed(&["study", study, "--quiet"]);
        // the document counts pushes instead of listing them; the last column of the laws is a time
        let rows = |text: &str| -> Vec<String> {
            let lines = text.lines().filter(|line| !line.contains("2 N·s"));
            lines
                .map(|line| line.rsplitn(if study == "laws" { 3 } else { 1 }, '|').last().unwrap_or(line).into())
                .collect()
        };
        let (shown, printed) = (rows(shown), rows(&printed));
        shown.iter().zip(&printed).for_each(|(shown, printed)| assert_eq!(shown, printed, "study {study}"));
        assert_eq!(shown.len(), printed.len(), "rows of study {study}");
    }
}
