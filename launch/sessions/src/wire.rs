//! `biped wire`: the wire format for programs in other languages.

use clap::{Args, ValueEnum};
use messages::describe;
use shared::output::print_text;

/// Arguments of `biped wire`.
#[derive(Args)]
pub struct WireArgs {
    /// Output format
    #[arg(value_enum)]
    language: WireFormat,
}

/// Output format of `biped wire`.
#[derive(Clone, Copy, ValueEnum)]
enum WireFormat {
    /// Header for C and C++
    C,
    /// Python module of ctypes structures
    Python,
    /// Markdown tables, to read
    Markdown,
}

/// Prints the wire format.
pub fn run(args: &WireArgs) {
    print_text(match args.language {
        WireFormat::C => describe::c_header(),
        WireFormat::Python => describe::python_module(),
        WireFormat::Markdown => describe::markdown(),
    });
}
