//! The program knows every command that a document shows: its subcommands, options, scenes and keys.

use crate::{code_spans, files, printed};
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// A key that the guide misspells to show the error message.
const MISSPELT: &str = "controller.sped";

/// All documents but the list of changes, which has former names: path and text.
pub fn documents() -> impl Iterator<Item = (PathBuf, String)> {
    let present = files(".", "md").into_iter().filter(|path| !path.ends_with("CHANGELOG.md"));
    present.map(|path| (path.clone(), std::fs::read_to_string(path).expect("a document")))
}

/// Code in a document: the lines of its shell blocks without comments, and its code spans. What is quoted stands by itself too.
pub fn pieces(document: &str) -> Vec<String> {
    let mut found: Vec<String> = code_spans(document).map(|span| span.replace('\n', " ")).collect();
    for (nr, part) in document.replace("\\\n", " ").split("```").enumerate() {
        let shell = part.starts_with("sh\n");
        let is_command = |line: &&str| if nr % 2 == 0 { line.starts_with("    ") } else { shell };
        found.extend(part.lines().filter(is_command).map(|line| line.split(" # ").next().unwrap_or(line).to_string()));
    }
    let quoted =
        |piece: &String| ['"', '\''].map(|quote| piece.split(quote).skip(1).step_by(2).map(String::from).collect());
    let inner: Vec<Vec<String>> = found.iter().flat_map(quoted).collect();
    found.extend(inner.concat());
    found
}

/// The words after each `biped` in a piece of code, up to the end of that command. Quoted text is one word.
fn commands(piece: &str) -> Vec<Vec<String>> {
    let mut plain = String::new();
    for (nr, part) in piece.split(['"', '\'']).enumerate() {
        plain += if nr % 2 == 0 { part } else { "QUOTED" };
    }
    let ends = plain.replace("--biped ", "--biped=").replace([';', '&', ')', '>', '<'], " ; ").replace(" | ", " ; ");
    let words: Vec<&str> = ends.split_whitespace().collect();
    let begins = |word: &&str| *word == "biped" || word.ends_with("/biped") && !word.contains([':', '=']);
    let is_command = |part: &&[&str]| {
        part.first().is_some_and(|word| word.starts_with(|c: char| c.is_ascii_lowercase() || c == '-'))
    };
    let parts = words.split(begins).skip(1).map(|rest| rest.split(|word| *word == ";").next().unwrap_or(rest));
    parts.filter(is_command).map(|part| part.iter().map(|word| word.to_string()).collect()).collect()
}

/// The program's own description of itself, each page printed once.
#[derive(Default)]
struct Help {
    pages: BTreeMap<Vec<String>, String>,
}

impl Help {
    fn page(&mut self, subcommand: &[String]) -> &str {
        let print = || printed(&subcommand.iter().map(String::as_str).chain(["--help"]).collect::<Vec<_>>());
        self.pages.entry(subcommand.to_vec()).or_insert_with(print)
    }

    /// Whether a page lists a subcommand of this name.
    fn lists(&mut self, subcommand: &[String], name: &str) -> bool {
        self.page(subcommand).lines().any(|line| line.strip_prefix("  ").is_some_and(|line| first(line) == name))
    }

    /// Whether a page has this option.
    fn has(&mut self, subcommand: &[String], option: &str) -> bool {
        let is_end = |c: char| !c.is_ascii_alphanumeric() && c != '-';
        self.page(subcommand).split(is_end).any(|word| word == option)
    }
}

fn first(text: &str) -> &str {
    text.split(' ').next().unwrap_or(text)
}

/// What is wrong with the words of a command.
fn defect(words: &[String], help: &mut Help, scenes: &BTreeSet<String>) -> Option<String> {
    let names: Vec<&str> = words[0].split('|').collect(); // `biped pause|resume`
    if let Some(name) = names.iter().find(|name| !name.starts_with('-') && !help.lists(&[], name)) {
        return Some(format!("there is no command `{name}`"));
    }
    let mut page: Vec<String> =
        names.first().filter(|name| !name.starts_with('-')).map(|name| name.to_string()).into_iter().collect();
    if help.page(&page).contains("\nCommands:") && words.len() > 1 {
        if !help.lists(&page, &words[1]) {
            return Some(format!("`{}` has no command `{}`", words[0], words[1]));
        }
        page.push(words[1].clone());
    }
    let option = |word: &String| {
        word.split('=').next().filter(|name| name.starts_with("--") && name.len() > 2).map(String::from)
    };
    if let Some(option) = words.iter().filter_map(option).find(|option| !help.has(&page, option)) {
        return Some(format!("`{}` has no option `{option}`", page.join(" ")));
    }
    let scene =
        words.get(1).filter(|_| ["run", "plant", "controller", "model", "sweep"].contains(&words[0].as_str()))?;
    let is_name =
        scene.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-') && !scene.starts_with('-');
    (is_name && !scenes.contains(scene)).then(|| format!("there is no scene `{scene}`"))
}

/// Whether a scene has a key. `NAME` in the list of keys stands for any name or number; a key may be a table or an entry of a list.
fn is_key(name: &str, keys: &[Vec<String>]) -> bool {
    let parts: Vec<&str> = name.split('.').collect();
    let fits = |key: &Vec<String>| {
        let entry = parts.len() == key.len() + 1 && parts.last().is_some_and(|last| last.parse::<u32>().is_ok());
        (parts.len() <= key.len() || entry) && key.iter().zip(&parts).all(|(key, part)| key == "NAME" || key == part)
    };
    keys.iter().any(fits)
}

/// The key in a word such as `plant.friction=0.3`.
fn key(word: &str) -> Option<&str> {
    let name = word.split_once('=')?.0;
    let named = name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || "._".contains(c));
    (named && ["plant.", "controller.", "link.", "initial.", "bodies."].iter().any(|table| name.starts_with(table)))
        .then_some(name)
}

#[test]
fn the_program_knows_every_command_option_scene_and_key_that_a_document_shows() {
    let mut help = Help::default();
    let scenes = printed(&["list"]).lines().map(|line| first(line).to_string()).collect();
    let listed = printed(&["list", "--keys"]);
    let keys: Vec<Vec<String>> =
        listed.lines().map(|line| first(line).split('.').map(String::from).collect()).collect();
    let (mut checked, mut defects) = ([0, 0], vec![]);
    for (document, text) in documents() {
        for piece in pieces(&text) {
            for words in commands(&piece) {
                let defect = defect(&words, &mut help, &scenes);
                defects.extend(defect.map(|defect| format!("{}: {defect}: {piece}", document.display())));
                checked[0] += 1;
            }
            for name in piece.split_whitespace().filter_map(key) {
                let unknown = (!is_key(name, &keys) && name != MISSPELT)
                    .then(|| format!("{}: there is no key `{name}`", document.display()));
                defects.extend(unknown);
                checked[1] += 1;
            }
        }
    }
    assert!(defects.is_empty(), "{}", defects.join("\n"));
    assert!(checked[0] > 250 && checked[1] > 40, "only {checked:?} commands and keys were found");
    let words = |text: &str| commands(text).remove(0);
    for wrong in ["biped walk", "biped run walk --fast", "biped run wlak", "biped new cat", "x; biped list --hash"] {
        assert!(defect(&words(wrong), &mut help, &scenes).is_some(), "{wrong}");
    }
    assert!(!is_key("plant.fricton", &keys) && is_key("plant.push_impulse.1", &keys));
}
