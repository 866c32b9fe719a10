//! Parts that all kinds of new folders share: templates, files, and a clone of this repository.

use clap::ValueEnum;
use shared::exit::{Exit, Failure};
use std::path::{Path, PathBuf};

/// A controller to begin from.
#[derive(Clone, Copy, ValueEnum)]
pub(super) enum Template {
    /// A spring and a damper in each joint
    Stand,
    /// The paper's controller
    Walk,
}

/// A file of a new folder: its name and its text.
pub type NewFile = (&'static str, String);

/// A failure for wrong usage.
pub(super) fn usage(sentence: impl ToString) -> Failure {
    Failure::new(Exit::Usage, sentence.to_string())
}

/// The absolute path of a clone of the repository of biped, in which `part` has to be.
pub(super) fn in_clone(tree: &Path, part: &str) -> Result<PathBuf, Failure> {
    let absolute = tree.canonicalize().unwrap_or_else(|_| tree.into());
    match absolute.join(part).exists() {
        true => Ok(absolute),
        false => Err(usage(format!("--tree {0}: there is no {0}/{part}, so it is no clone of biped", tree.display()))),
    }
}

/// A path as a word of a shell, also between double quotes.
pub(super) fn shell_word(path: &Path) -> String {
    let text = path.display().to_string();
    let is_plain = |c: char| c.is_alphanumeric() || "/._-".contains(c);
    if text.chars().all(is_plain) { text } else { format!("'{}'", text.replace('\'', r"'\''")) }
}

/// A source text without the comment at its head, which tells how to build it in this repository.
pub(super) fn code<'a>(text: &'a str, first: &str) -> &'a str {
    text.find(first).map_or(text, |begin| &text[begin..])
}
