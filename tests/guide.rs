//! The outputs in the guide are those of its commands. The quick ones run one after the other in an empty folder.
//!
//! A block of commands under `<!-- checked -->` is run by bash; `<!-- checked: exit 7 -->` names another exit code. Each line of the next
//! block of text must be in the output; `…` stands for any text. A block under `<!-- file: NAME -->` is written to that file.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Stdio};

const GUIDE: &str = include_str!("../docs/GUIDE.md");

/// The next fenced block of a text, and the rest of the text after it.
fn block(text: &str) -> (&str, &str) {
    let inside = text.split_once("```").expect("a fence").1.split_once('\n').expect("a line").1;
    inside.split_once("```\n").expect("the end of a block")
}

/// The output of bash, standard error first. Asserts that the exit code is `code`.
fn printed(commands: &str, code: i32, folder: &Path) -> String {
    let programs = [Path::new(env!("CARGO_BIN_EXE_biped")), languages::python()].map(|program| program.parent());
    let folders = programs.map(|folder| folder.expect("a folder").display().to_string());
    let path = format!("{}:{}", folders.join(":"), std::env::var("PATH").unwrap_or_default());
    let mut bash = Command::new("bash");
    bash.args(["-e", "-c", commands]).env("PATH", path).current_dir(folder).stdin(Stdio::null());
    let output = bash.output().expect("bash");
    let text = [output.stderr, output.stdout].map(|bytes| String::from_utf8(bytes).expect("text")).concat();
    assert_eq!(output.status.code(), Some(code), "{commands}\n{text}");
    text
}

/// Whether a line has the parts of another between its ellipses, in that order.
fn shows(line: &str, shown: &str) -> bool {
    let mut rest = Some(line);
    for part in shown.split('…') {
        rest = rest.and_then(|rest| rest.split_once(part)).map(|(_, behind)| behind);
    }
    rest.is_some()
}

#[test]
fn the_steps_of_the_guide_print_the_output_that_it_shows() {
    let folder = common::fresh_path("guide");
    std::fs::create_dir(&folder).expect("a folder of our own");
    symlink(concat!(env!("CARGO_MANIFEST_DIR"), "/controller"), folder.join("controller")).expect("a link");
    let mut steps = 0;
    for marked in GUIDE.split("<!-- ").skip(1) {
        let (mark, rest) = marked.split_once(" -->\n").expect("the end of a mark");
        let (body, rest) = block(rest);
        if let Some(name) = mark.strip_prefix("file: ") {
            std::fs::write(folder.join(name), body).expect("a file of our own");
            continue;
        }
        let code = mark.strip_prefix("checked: exit ").map_or(0, |code| code.parse().expect("an exit code"));
        let printed = printed(body, code, &folder);
        for shown in block(rest).0.lines() {
            assert!(
                printed.lines().any(|line| shows(line, shown)),
                "`{shown}` is not in what\n{body}prints:\n{printed}"
            );
        }
        steps += 1;
    }
    assert!(steps >= 10, "{steps}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}
