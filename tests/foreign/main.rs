//! Claims about foreign programs: controllers in Python and a plant in MuJoCo walk like the built-in ones, failures are named, other simulators
//! compute the same equations of motion from the exported robot, and other readers open the recordings.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/languages.rs"]
mod languages;

mod files;
mod rules;
mod walks;

use common::fresh_path;
use serde_json::Value;
use std::process::{Command, Output};

/// Runs a scene. Returns the output, and the summary if there is one.
fn run(scene: &str, arguments: &[&str]) -> (Output, Value) {
    let folder = fresh_path("foreign");
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--quiet", "--out"])
        .arg(&folder)
        .args(arguments)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("OPENBLAS_NUM_THREADS", "1") // with eight joints, threads only cost time
        .output()
        .expect("the program starts");
    let summary = std::fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let _ = std::fs::remove_dir_all(folder);
    (output, serde_json::from_str(&summary).unwrap_or_default())
}

fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key} in {summary}"))
}
