//! Claims about the documents: they show exactly what the program prints, and the commands, files and identifiers that they name exist.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod command_files;
mod commands;
mod style;

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
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
        (between(include_str!("../../README.md"), "```\n", "```"), printed(&["run", "walk", "--quiet"]));
    assert!(shown.lines().count() > 5, "{shown}");
    for line in shown.lines() {
        assert!(printed.lines().any(|printed| printed == line), "`{line}` is not in\n{printed}");
    }
}

#[test]
fn the_scenes_document_lists_the_keys_of_a_summary() {
    let folder = std::env::temp_dir().join(format!("biped-summary-{}", std::process::id()));
    printed(&["run", "slide", "--in-process", "--quiet", "--out", folder.to_str().expect("a name")]);
    let summary = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    std::fs::remove_dir_all(&folder).expect("our own folder");
    let keys = summary.lines().filter_map(|line| line.strip_prefix("  \"")?.split('"').next()).collect::<BTreeSet<_>>();
    let table = between(include_str!("../../docs/SCENES.md"), "### Keys of summary.json", "\n## ");
    let rows = table.lines().filter_map(|line| line.strip_prefix("| `")?.split(" | ").next());
    let listed: BTreeSet<_> =
        rows.flat_map(|names| names.split('`')).filter(|name| name.contains(char::is_alphabetic)).collect();
    assert!(keys.len() > 40, "{keys:?}");
    assert_eq!(keys, listed);
}

#[test]
fn the_paper_document_shows_the_tables_of_the_studies() {
    for study in ["laws", "attraction", "endurance", "margins", "pushes"] {
        let shown =
            between(include_str!("../../docs/PAPER.md"), &format!("<!-- study:{study} -->\n"), "<!-- /study -->");
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

/// All but the times, which are those of a machine.
#[test]
fn the_accuracy_document_shows_the_orders_and_errors_of_the_methods() {
    let folder = std::env::temp_dir().join(format!("biped-orders-{}", std::process::id()));
    let printed = printed(&["chart", "--orders", "--out", folder.to_str().expect("a name")]);
    std::fs::remove_dir_all(&folder).expect("our own folder");
    let shown = between(include_str!("../../docs/ACCURACY.md"), "    biped chart --orders\n", "\n- ");
    let rows = |text: &str| -> Vec<String> {
        let lines = text.lines().filter(|line| line.starts_with('|') && !line.starts_with("|-"));
        let words = |cell: &str| cell.trim().split(", ").take(2).collect::<Vec<_>>().join(", ");
        lines.map(|line| line.split('|').map(words).collect::<Vec<_>>().join("|")).collect()
    };
    assert_eq!(rows(shown), rows(&printed));
    assert_eq!(rows(shown).len(), 11, "{shown}");
}

/// The first map of links is compared, not the six of the document: they would take as long as all other claims about documents.
#[test]
fn the_reliability_document_shows_the_limits_of_the_links_and_of_the_servo() {
    let folder = std::env::temp_dir().join(format!("biped-documents-{}", std::process::id()));
    let [links, servo] = ["links", "servo"].map(|name| {
        between(
            include_str!("../../docs/RELIABILITY.md"),
            &format!("<!-- robustness:{name} -->\n"),
            "<!-- /robustness -->",
        )
    });
    let delays = "--seeds 1 --delay 0,1,2,3,4,5,6,7 --jitter 0 --with controller.switch_rate=60,80,120 --with \
        controller.observer_bandwidth=10,20,40";
    for (shown, options) in [(links, ""), (servo, delays)] {
        let words = ["robustness", "--quiet", "--loss", "0", "--out", folder.to_str().expect("a name")];
        let printed = printed(&words.into_iter().chain(options.split_whitespace()).collect::<Vec<_>>());
        let rows = printed.lines().filter(|line| line.starts_with('|')).collect::<Vec<_>>();
        assert!(
            rows.len() > 2 && rows.iter().zip(shown.lines()).all(|(row, shown)| *row == shown),
            "{printed}\n{shown}"
        );
        std::fs::remove_dir_all(&folder).expect("our own folder");
    }
}

/// All files below a folder, except those of builds and hidden ones.
fn files_below(folder: &Path, found: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry")) {
        let (path, name) = (entry.path(), entry.file_name());
        let skipped = name == "target" || name == "out" || name.to_string_lossy().starts_with('.');
        match path.is_dir() {
            true if !skipped => files_below(&path, found),
            true => {}
            false => found.push(path),
        }
    }
}

fn files(folder: &str, extension: &str) -> Vec<PathBuf> {
    let mut found = vec![];
    files_below(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found);
    found.retain(|path| path.extension().is_some_and(|found| found == extension));
    found
}

/// The title of the paper is cited in documents, comments and the report, and a rename in the code must not change it.
#[test]
fn the_title_of_the_paper_is_whole_wherever_it_is_cited() {
    let (begin, title) = ("Eight-Axis", "Eight-Axis Biped Robot");
    let mut citations = 0;
    for file in ["docs", "launch", "plant", "controller", "messages", "examples"]
        .iter()
        .flat_map(|folder| ["md", "rs", "py", "toml", "js"].into_iter().flat_map(move |kind| files(folder, kind)))
        .chain(["README.md".into(), "CHANGELOG.md".into()])
    {
        let text = std::fs::read_to_string(&file).expect("a text");
        let plain = text.split_whitespace().collect::<Vec<_>>().join(" ");
        citations += plain.matches(begin).count();
        assert_eq!(plain.matches(begin).count(), plain.matches(title).count(), "{}", file.display());
    }
    assert!(citations >= 4, "{citations}");
}

/// The parts of a text between backticks.
fn code_spans(text: &str) -> impl Iterator<Item = &str> {
    text.split("```").step_by(2).flat_map(|prose| prose.split('`').skip(1).step_by(2))
}

/// The source file that a document names, by the end of its path. `P` and `C` are the abbreviations of docs/PAPER.md.
fn source<'a>(name: &str, sources: &'a [PathBuf]) -> Option<&'a PathBuf> {
    let full = match name.split_once('/') {
        Some(("P", rest)) => format!("plant/src/{rest}"),
        Some(("C", rest)) => format!("controller/src/{rest}"),
        _ => name.to_string(),
    };
    sources.iter().find(|path| path.ends_with(&full))
}

#[test]
fn every_source_file_that_a_document_names_exists() {
    let sources = files(".", "rs");
    let mut named = 0;
    for document in files("docs", "md").into_iter().chain(["README.md", "CONTRIBUTING.md"].map(PathBuf::from)) {
        let text = std::fs::read_to_string(&document).expect("a document");
        let present = text.split("## Files renamed").next().expect("a part"); // it has the former names
        for name in code_spans(present).filter(|name| name.ends_with(".rs") && !name.contains(' ')) {
            assert!(source(name, &sources).is_some(), "{}: there is no file `{name}`", document.display());
            named += 1;
        }
    }
    assert!(named > 150, "only {named} names were found");
    assert!(source("P/step/euler_.rs", &sources).is_none() && source("uler.rs", &sources).is_none());
}

/// The text of some sources.
fn code_of(paths: impl IntoIterator<Item = impl AsRef<Path>>) -> String {
    paths.into_iter().map(|path| std::fs::read_to_string(path).expect("a source")).collect()
}

/// Whether a source defines a function, a type or a public field of this name, or methods of the type.
fn defines(code: &str, name: &str) -> bool {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    ["fn ", "struct ", "enum ", "impl ", "pub "]
        .iter()
        .any(|keyword| code.split(&format!("{keyword}{name}")).skip(1).any(|rest| !rest.starts_with(is_name)))
}

/// Each row of the table of equations names files and identifiers, which one of these files must define.
#[test]
fn every_identifier_of_the_table_of_equations_is_defined_in_a_file_of_its_row() {
    let sources = files(".", "rs");
    let table = between(include_str!("../../docs/PAPER.md"), "## Where each equation is", "\n## ");
    let is_name = |span: &&str| span.chars().all(|c| c.is_ascii_alphanumeric() || "_:".contains(c));
    let mut checked = 0;
    for row in table.lines().filter(|line| line.starts_with('|')) {
        let code = code_of(code_spans(row).filter_map(|span| source(span, &sources)));
        for name in code_spans(row).filter(is_name).flat_map(|span| span.split("::")).filter(|name| !name.is_empty()) {
            assert!(defines(&code, name), "no file of this row defines `{name}`:\n{row}");
            checked += 1;
        }
    }
    assert!(checked > 50, "only {checked} identifiers were found");
    assert!(defines("pub fn energy(", "energy") && !defines("pub fn energy_gain(", "energy"));
}

#[test]
fn every_identifier_of_the_glossary_is_a_word_of_the_code() {
    let folders = ["plant", "controller", "messages", "launch"].into_iter().flat_map(|folder| files(folder, "rs"));
    let code = code_of(folders);
    let is_word = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let words: BTreeSet<&str> = code.split(|c: char| !is_word(c)).collect();
    let names = code_spans(include_str!("../../docs/GLOSSARY.md")).flat_map(|span| span.split("::"));
    let names: Vec<&str> = names.filter(|name| !name.is_empty() && name.chars().all(is_word)).collect();
    assert!(names.len() > 50, "only {} identifiers were found", names.len());
    for name in names {
        assert!(words.contains(name), "the code has no `{name}`");
    }
}

#[test]
fn every_test_that_the_paper_document_names_exists() {
    let code = code_of(files(".", "rs"));
    let is_test = |name: &&str| name.matches('_').count() > 4 && !name.contains(['/', '.', ' ']);
    let names: Vec<&str> = code_spans(include_str!("../../docs/PAPER.md")).filter(is_test).collect();
    assert!(names.len() > 10, "{names:?}");
    for name in names {
        assert!(code.contains(&format!("fn {name}()")), "there is no test `{name}`");
    }
}
