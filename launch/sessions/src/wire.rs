//! `biped wire`: the wire format for other languages.

use clap::{Args, ValueEnum};
use messages::describe;
use shared::output::say;

/// Arguments of `biped wire`.
#[derive(Args)]
pub struct WireArgs {
    /// For whom
    #[arg(value_enum)]
    language: Language,
}

/// For whom the wire format is printed.
#[derive(Clone, Copy, ValueEnum)]
enum Language {
    /// A header for C and C++
    C,
    /// A module of ctypes structures
    Python,
    /// Tables for people
    Markdown,
}

/// Prints it.
pub fn run(args: &WireArgs) {
    say(match args.language {
        Language::C => describe::c_header(),
        Language::Python => describe::python_module(),
        Language::Markdown => describe::markdown(),
    });
}
