//! Other simulators on the same scenes, by scripts of their own, in the same session on the same machine.

use super::csv::{Row, parse};
use super::watch::Watch;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::check_replaceable;
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

/// The script, in the folder that this was built from.
const SCRIPT: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/peers/run.py");

/// What to know of them besides.
pub const REMARK: &str = "Siconos and Pinocchio solve contact and step nothing: the steppers around them are ours; Siconos has rows for single \
    bodies only, and for the time of its solver alone.";

/// Runs the script and reads the rows that it left in `folder`; also a sentence for each engine that is missing.
///
/// # Errors
/// Ctrl-C, no Python, a script that fails, or a table that is none.
pub fn rows(folder: &Path, scenes: &[String], quick: bool, watch: &Watch) -> Result<(Vec<Row>, Vec<String>), Failure> {
    let table = folder.join("peers.csv");
    let fault = |message: String| Failure::new(Exit::Fault, format!("--peers: {message}"));
    check_replaceable(&table, b"view,scene,engine").map_err(|error| fault(format!("{}: {error}", table.display())))?;
    let mut command = Command::new("python3");
    command.arg(SCRIPT).arg("--out").arg(&table).args(quick.then_some("--quick")).stdout(Stdio::piped());
    if !scenes.is_empty() {
        command.arg("--scenes").args(scenes);
    }
    let mut script = command.spawn().map_err(|error| fault(format!("python3 does not start: {error}")))?;
    let mut left_out = Vec::new();
    for line in script.stdout.take().into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok) {
        watch.tell(&line);
        if line.split_once(" left out, ").is_some_and(|(engine, _)| !engine.contains(' ')) {
            left_out.push(format!("{line}."));
        }
        if check_interrupt(watch.stop).is_err() {
            let _ = script.kill();
        }
    }
    let status = script.wait().map_err(|error| fault(error.to_string()))?;
    check_interrupt(watch.stop)?;
    if !status.success() {
        return Err(fault(format!("{SCRIPT} ended with {status}")));
    }
    Ok((read(&table)?, left_out))
}

/// The rows of a table that was measured before.
///
/// # Errors
/// A file that cannot be read, or is no such table.
pub fn read(table: &Path) -> Result<Vec<Row>, Failure> {
    let named = |error: String| Failure::new(Exit::Usage, format!("--peers: {}: {error}", table.display()));
    let text = messages::file::text(table).map_err(|error| named(error.to_string()))?;
    parse(&text).map_err(named)
}
