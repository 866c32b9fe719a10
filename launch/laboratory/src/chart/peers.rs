//! Other simulators on the same scenes, run by Python scripts in the same session on the same machine.

mod resolved;
mod runs;
pub mod scripts;

use super::cases::{CASES, ComparisonScene};
use super::csv::{Measurement, parse, table};
use super::watch::ChartProgress;
use sessions::process::Process;
use sessions::scaffold::NewFile;
use shared::exit::{Exit, Failure, check_interrupt};
use shared::output::{create_folder as make, write_atomically};
use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

/// The first line of a table of other simulators.
pub const HEAD: &str = "# Other simulators, measured by `biped chart --peers`.\n";

/// A remark for the page.
pub const REMARK: &str = "Siconos and Pinocchio solve contact and step nothing: the steppers around them are ours; Siconos has rows for single \
    bodies only, and for the time of its solver alone.";

/// Copies the scripts into the folder `peers` below `folder`, runs them there, and computes errors. Also returns a sentence for each engine
/// that is left out.
///
/// Writes the rows to `peers.csv`, below day, machine and versions. [`read`] reads this file.
///
/// # Errors
/// Ctrl-C, no Python, a script that fails, or runs that cannot be read.
pub fn measure(
    folder: &Path,
    chosen: &[ComparisonScene],
    quick: bool,
    watch: &ChartProgress,
) -> Result<(Vec<Measurement>, Vec<String>), Failure> {
    let files = folder.join("peers");
    let fault = |message: String| Failure::new(Exit::Fault, format!("--peers: {message}"));
    make(&files)?;
    let scenes = resolved::text(chosen, quick)?;
    write_atomically(&files.join("scenes.toml"), &scenes).map_err(|error| fault(error.to_string()))?;
    let program = scripts::copy(&files, "run.py")?;
    let mut command = Command::new("python3");
    command.arg(&program).arg(&files).args(quick.then_some("--quick")).stdout(Stdio::piped());
    let mut script = Process::start(&mut command).map_err(|error| fault(format!("python3 does not start: {error}")))?;
    let mut left_out = Vec::new();
    for line in script.stdout().into_iter().flat_map(|out| BufReader::new(out).lines()).map_while(Result::ok) {
        watch.log(&line);
        if line.split_once(" left out, ").is_some_and(|(engine, _)| !engine.contains(' ')) {
            left_out.push(format!("{line}."));
        }
        check_interrupt(watch.stop)?;
    }
    let status = script.wait(Duration::MAX).ok_or_else(|| fault(format!("{} did not end", program.display())))?;
    check_interrupt(watch.stop)?;
    if !status.success() {
        return Err(fault(format!("{} ended with {status}", program.display())));
    }
    let rows = runs::measure(&files)?;
    let origin = messages::file::text(&files.join("origin.txt")).map_err(|error| fault(error.to_string()))?;
    let origin: String = origin.lines().map(|line| format!("# {line}\n")).collect();
    let text = format!("{HEAD}{origin}{}", table(&rows));
    write_atomically(&folder.join("peers.csv"), &text).map_err(|error| fault(error.to_string()))?;
    Ok((rows, left_out))
}

/// The scripts with their scenes, for a folder of one's own.
///
/// # Errors
/// A scene that is refused.
pub fn files(folder: &Path) -> Result<Vec<NewFile>, Failure> {
    let (own, scenes) = (folder.display(), resolved::text(&CASES, false)?);
    let head = format!(
        "    python3 {own}/run.py {own} --engines mujoco    # installs the engine into a virtual environment and runs it\n    \
         biped chart --peers={own}                      # errors and drawings from the runs in this folder\n\n\
         `requirements.txt` lists the Python packages of all engines with their versions. `run.py` installs them by itself.\n\n"
    );
    let text = |(name, text): (&'static str, &str)| match name {
        "README.md" => (name, format!("{head}{text}")),
        _ => (name, text.to_string()),
    };
    let more = [("scenes.toml", scenes), ("requirements.txt", scripts::requirements())];
    Ok(scripts::SCRIPTS.into_iter().map(text).chain(more).collect())
}

/// The rows of a table that was measured before, or of a folder in which the script ran.
///
/// # Errors
/// A file that cannot be read, is not such a table, or has another scene.
pub fn read(table: &Path) -> Result<Vec<Measurement>, Failure> {
    if table.is_dir() {
        return runs::measure(table);
    }
    let named = |error: String| Failure::new(Exit::Usage, format!("--peers: {}: {error}", table.display()));
    let text = messages::file::text(table).map_err(|error| named(error.to_string()))?;
    let rows = parse(&text).map_err(named)?;
    match rows.iter().find(|row| CASES.iter().all(|case| case.name != row.scene)) {
        None => Ok(rows),
        Some(row) => {
            let names: Vec<_> = CASES.iter().map(|case| case.name).collect();
            Err(named(format!("`{}` is no comparison scene, which are {}", row.scene, names.join(", "))))
        }
    }
}
