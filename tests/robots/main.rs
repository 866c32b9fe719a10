//! Claims about robots in files: the paper's robot survives export and import bit for bit, robots of another size walk as dynamic similarity
//! predicts, robots of another shape walk, a file that is no biped is refused with a sentence, and what is not read is told.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

mod bounds;
#[path = "../common/mod.rs"]
mod common;
mod files;
mod notes;
mod round_trip;
mod shapes;

use std::process::{Command, Output};

fn biped(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).output().expect("the program starts")
}

fn export(format: &str, arguments: &[&str]) -> String {
    let output = biped(&[&["export", format], arguments].concat());
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("plain text")
}
