//! Errors of loading a scene or a robot.

use super::{BuiltIn, suggestion};
use thiserror::Error;

/// Longest line of a file that an error quotes [characters].
const LONGEST_QUOTE: usize = 200;

/// Why a scene or a robot is refused.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The name is neither that of a built-in scene nor that of a file.
    #[error("there is no scene or file `{name}`; the built-in scenes are {known}{}", suggestion::suggest(name, known.split(", ")))]
    Unknown {
        /// Name as given.
        name: String,
        /// Names of the built-in scenes.
        known: String,
    },
    /// The file exists but cannot be read.
    #[error("{path} cannot be read: {reason}")]
    Unreadable {
        /// Path of the file.
        path: String,
        /// Error of the operating system.
        reason: std::io::Error,
    },
    /// The text is not TOML, has an unknown key, or has a value of the wrong type.
    #[error("{origin}: {}{}", in_plain_words(&shortened(reason)), suggestion::suggest_from_error(reason.message()))]
    Malformed {
        /// File or built-in scene.
        origin: String,
        /// Error of the parser: it shows the line with a caret and lists the valid names.
        reason: Box<toml::de::Error>,
    },
    /// An override cannot be applied.
    #[error("--set {setting}: {reason}")]
    Override {
        /// Override as given.
        setting: String,
        /// Why it cannot be applied.
        reason: String,
    },
    /// A robot cannot be used.
    #[error("{origin}: {reason}")]
    Robot {
        /// File of the robot, or the scene that uses it.
        origin: String,
        /// Why it cannot be used.
        reason: String,
    },
    /// A value is out of range.
    #[error("{origin}: {key} = {value}, but {rule}")]
    Invalid {
        /// File or built-in scene, with its overrides.
        origin: String,
        /// Dotted key.
        key: String,
        /// Value as given.
        value: String,
        /// Values that are allowed.
        rule: String,
    },
}

impl SceneError {
    pub(super) fn unknown(name: &str, built_in: &[BuiltIn]) -> SceneError {
        let known = built_in.iter().map(|(name, _)| *name).collect::<Vec<_>>().join(", ");
        SceneError::Unknown { name: name.into(), known }
    }
}

/// Text of serde's error with the kinds of numbers in plain words instead of Rust's.
pub(super) fn in_plain_words(error: &str) -> String {
    let whole = "expected a whole number of 0 or more";
    let up_to = |most: u64| format!("{whole} and at most {most}");
    let kinds = [
        ("f64", "expected a number".into()),
        ("u16", up_to(u16::MAX.into())),
        ("u32", up_to(u32::MAX.into())),
        ("u64", whole.into()),
        ("usize", whole.into()),
    ];
    kinds.iter().fold(error.into(), |text: String, (kind, words)| text.replace(&format!("expected {kind}"), words))
}

/// Text of a parser's error in which quoted lines are cut to [`LONGEST_QUOTE`]. A quoted line follows its number and a bar.
fn shortened(error: &toml::de::Error) -> String {
    let is_quoted = |line: &str| line.trim_start_matches(|c: char| c == ' ' || c.is_ascii_digit()).starts_with('|');
    let cut = |line: &str| match line.char_indices().nth(LONGEST_QUOTE).filter(|_| is_quoted(line)) {
        Some((end, _)) => format!("{}…\n", &line[..end]),
        None => format!("{line}\n"),
    };
    error.to_string().lines().map(cut).collect::<String>().trim_end().to_string()
}
