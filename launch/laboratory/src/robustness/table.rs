//! The table: one row for each run. Rows are appended as runs end and sorted at the end.

use super::grid::{Grid, SweepRun};
use crate::study::RunOutcome;
use records::summary::Summary;
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::output::{check_replaceable, lock_for_writing, write_atomically, write_failure};
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

const HEADER: &str = "case,with,delay_ms,jitter_ms,jitter,loss,seed,outcome,fall_s,speed_mps,period_s,period_std_ms,drift_m,tilt_deg,hash";
/// Number of result cells of a row.
const RESULTS: usize = 8;
/// Result of a run without a fall.
pub const UP: &str = "up";

/// The rows of finished runs by number, and the locked file to which they are appended.
pub struct Table {
    path: PathBuf,
    begin: String,
    growing: Mutex<(File, Vec<Option<String>>)>,
}

impl Table {
    /// Opens a table with the rows of an earlier run of the same sweep. An incomplete last row is dropped.
    ///
    /// # Errors
    /// A file of another sweep, a file that another process is writing, or one that cannot be written.
    pub fn resume(path: &Path, grid: &Grid, cases: &[SweepRun]) -> Result<Table, Failure> {
        let failed = |error: std::io::Error| write_failure(path, &error);
        let (mut rows, mut old, begin) = (vec![None; cases.len()], String::new(), begin(grid));
        check_replaceable(path, begin.as_bytes()).map_err(failed)?;
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        lock_for_writing(&file, || {
            format!("another sweep is writing {}: wait for it, or choose another --out", path.display())
        })?;
        file.read_to_string(&mut old).map_err(|error| unreadable(path, &error))?;
        take(path, &old, grid, cases, &mut rows)
            .map_err(|failure| Failure::new(failure.exit, format!("{}; choose another --out", failure.message)))?;
        match whole(&old).len() {
            length if length >= begin.len() => file.set_len(length as u64).map_err(failed)?,
            _ => file.set_len(0).and_then(|()| file.write_all(begin.as_bytes())).map_err(failed)?,
        }
        Ok(Table { path: path.into(), begin, growing: Mutex::new((file, rows)) })
    }

    /// Whether a run has a row.
    pub fn has(&self, number: usize) -> bool {
        self.growing.lock().unwrap_or_else(PoisonError::into_inner).1[number].is_some()
    }

    /// Adds the outcome of a run, also to the file.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn append(&self, case: &SweepRun, outcome: &RunOutcome) -> Result<(), Failure> {
        let row = csv::text([[&key(case)[..], &results(outcome)].concat()]);
        let mut growing = self.growing.lock().unwrap_or_else(PoisonError::into_inner);
        growing.0.write_all(row.as_bytes()).map_err(|error| write_failure(&self.path, &error))?;
        growing.1[case.number] = Some(row);
        Ok(())
    }

    /// Sorts the file and returns the rows.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn finish(self) -> Result<Vec<Option<String>>, Failure> {
        let rows = self.growing.into_inner().unwrap_or_else(PoisonError::into_inner).1;
        write_atomically(&self.path, &joined(&self.begin, &rows)).map_err(|error| write_failure(&self.path, &error))?;
        Ok(rows)
    }
}

/// The rows of several tables of one sweep.
///
/// # Errors
/// A file of another sweep, rows that contradict each other, or a run without a row.
pub fn merge(paths: &[PathBuf], grid: &Grid, cases: &[SweepRun]) -> Result<Vec<Option<String>>, Failure> {
    let mut rows = vec![None; cases.len()];
    for path in paths {
        let text = messages::file::text(path).map_err(|error| unreadable(path, &error))?;
        take(path, &text, grid, cases, &mut rows)?;
    }
    let missing = rows.iter().filter(|row| row.is_none()).count();
    match rows.iter().position(Option::is_none) {
        None => Ok(rows),
        Some(first) => {
            let message = format!("{missing} of {} runs are in none of the files, run {first} among them", rows.len());
            Err(Failure::new(Exit::Usage, message))
        }
    }
}

/// The whole table as text.
pub fn text(grid: &Grid, rows: &[Option<String>]) -> String {
    joined(&begin(grid), rows)
}

/// The results in a row: outcome, time of the fall and so on, as far as they apply. Empty if the row belongs to another run.
pub fn cells(case: &SweepRun, row: &str) -> Vec<String> {
    let cells = csv::rows(row).unwrap_or_default().concat();
    cells.strip_prefix(&key(case)[..]).map_or(vec![], <[String]>::to_vec)
}

fn joined(begin: &str, rows: &[Option<String>]) -> String {
    [begin].into_iter().chain(rows.iter().flatten().map(String::as_str)).collect()
}

/// The first two lines: the sweep, and the names of the columns.
fn begin(grid: &Grid) -> String {
    format!("# biped {} robustness, sweep {:016x}\n{HEADER}\n", env!("CARGO_PKG_VERSION"), grid.hash())
}

/// The cells that name a run.
fn key(case: &SweepRun) -> [String; 7] {
    let link = &case.link;
    let jitter = format!("{:?}", link.jitter).to_lowercase();
    let [delay, spread, loss, seed] =
        [&link.delay_ms as &dyn ToString, &link.jitter_ms, &link.loss, &link.seed].map(ToString::to_string);
    [case.number.to_string(), case.variation.name.clone(), delay, spread, jitter, loss, seed]
}

fn results(outcome: &RunOutcome) -> [String; RESULTS] {
    let mut cells = [const { String::new() }; RESULTS];
    match outcome {
        Err(words) => cells[0] = words.replace([',', '\n'], ";"),
        Ok(Summary { fall_time_s: Some(time), .. }) => {
            (cells[0], cells[1]) = ("fell".into(), format!("{time:.3}"));
        }
        Ok(up) => {
            let numbers = [
                (up.speed_mps, 4),
                (up.period_s, 4),
                (1e3 * up.period_std_s, 2),
                (up.lateral_max_m, 4),
                (up.foot_tilt_max_deg, 3),
            ];
            cells[0] = UP.into();
            for (cell, (value, digits)) in cells[2..].iter_mut().zip(numbers) {
                *cell = if value.is_finite() { format!("{value:.digits$}") } else { String::new() };
            }
            cells[RESULTS - 1] = up.trajectory_hash.clone();
        }
    }
    cells
}

/// Reads the rows of a file into `rows`.
fn take(path: &Path, text: &str, grid: &Grid, cases: &[SweepRun], rows: &mut [Option<String>]) -> Result<(), Failure> {
    let refuse = |words: String| Failure::new(Exit::Usage, format!("{} {words}", path.display()));
    let (whole, begin) = (whole(text), begin(grid));
    let Some(body) = whole.strip_prefix(&begin) else {
        return match begin.starts_with(text) {
            true => Ok(()),
            false => Err(refuse("is the table of another sweep: another scene, grid or version".into())),
        };
    };
    for line in body.split_inclusive('\n') {
        let case = line.split(',').next().and_then(|number| cases.get(number.parse::<usize>().ok()?));
        let Some(case) = case.filter(|case| cells(case, line).len() == RESULTS) else {
            return Err(refuse(format!("has a line that is not a row of this sweep: `{}`", line.trim_end())));
        };
        match &rows[case.number] {
            Some(known) if known != line => {
                return Err(refuse(format!("has another result for run {} than the file before", case.number)));
            }
            _ => rows[case.number] = Some(line.into()),
        }
    }
    Ok(())
}

/// The text without an incomplete last row.
fn whole(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..=end])
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Usage, format!("{} cannot be read: {error}", path.display()))
}
