//! The table: one row for each run. Rows are appended as runs end and sorted at the end.

use shared::csv;
use shared::exit::{Exit, Failure};
use shared::output::{check_replaceable, create_failure, lock_for_writing, write_atomically, write_failure};
use std::fs::{File, OpenOptions};
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

/// The parts of a table that do not depend on the results of its runs.
#[derive(Default)]
pub struct Form {
    /// The first two lines: the command with a hash of all its runs, and the names of the columns.
    pub begin: String,
    /// The cells that name each run, after its number.
    pub keys: Vec<Vec<String>>,
    /// Number of result cells of a row.
    pub results: usize,
}

/// A row, as a line of the file and as result cells.
#[derive(Clone, PartialEq)]
pub struct Row {
    /// The line, with its end.
    pub line: String,
    /// The results.
    pub results: Vec<String>,
}

impl Form {
    /// The form of the table of a command whose runs have this hash, with these columns.
    pub fn new<'a>(
        command: &str,
        hash: u64,
        keys: Vec<Vec<String>>,
        names: impl IntoIterator<Item = &'a str>,
        results: usize,
    ) -> Form {
        let columns = csv::text([names]);
        let begin = format!("# biped {} {command}, sweep {hash:016x}\n{columns}", env!("CARGO_PKG_VERSION"));
        Form { begin, keys, results }
    }

    /// The whole table as text.
    pub fn text<'a>(&self, rows: impl IntoIterator<Item = &'a Row>) -> String {
        [self.begin.as_str()].into_iter().chain(rows.into_iter().map(|row| row.line.as_str())).collect()
    }

    fn row(&self, number: usize, results: &[String]) -> Row {
        let cells = [&[number.to_string()], &self.keys[number][..], results].concat();
        Row { line: csv::text([cells]), results: results.to_vec() }
    }

    /// The run of a line and its row; `None` if it is no row of this table.
    fn parse(&self, line: &str) -> Option<(usize, Row)> {
        let cells = csv::rows(line).ok()?.concat();
        let number: usize = cells.first()?.parse().ok()?;
        let results = cells[1..].strip_prefix(&self.keys.get(number)?[..])?;
        (results.len() == self.results).then(|| (number, Row { line: line.into(), results: results.to_vec() }))
    }

    /// Reads the rows of a file into `rows`.
    fn take(&self, path: &Path, text: &str, rows: &mut [Option<Row>]) -> Result<(), Failure> {
        let refuse = |words: String| Failure::new(Exit::Usage, format!("{} {words}", path.display()));
        let Some(body) = whole(text).strip_prefix(&self.begin) else {
            return match self.begin.starts_with(text) {
                true => Ok(()),
                false => Err(refuse(
                    "is the table of another sweep, or was edited: another scene, grid, version or first lines".into(),
                )),
            };
        };
        for line in body.split_inclusive('\n') {
            let Some((number, row)) = self.parse(line) else {
                return Err(refuse(format!("has a line that is not a row of this sweep: `{}`", line.trim_end())));
            };
            match &rows[number] {
                Some(known) if *known != row => {
                    return Err(refuse(format!("has another result for run {number} than the file before")));
                }
                _ => rows[number] = Some(row),
            }
        }
        Ok(())
    }
}

/// The rows of finished runs by number, and the locked file to which they are appended.
pub struct Table<'a> {
    path: PathBuf,
    form: &'a Form,
    growing: Mutex<(File, Vec<Option<Row>>)>,
}

impl Table<'_> {
    /// Opens a table with the rows of an earlier run of the same batch. An incomplete last row is dropped.
    ///
    /// # Errors
    /// A file of another batch, a file that another process is writing, or one that cannot be written.
    pub fn resume<'a>(path: &Path, form: &'a Form) -> Result<Table<'a>, Failure> {
        let failed = |error: std::io::Error| write_failure(path, &error);
        let (mut rows, mut old) = (vec![None; form.keys.len()], String::new());
        check_replaceable(path, form.begin.as_bytes()).map_err(|error| create_failure(path, &error))?;
        let mut file = OpenOptions::new().read(true).append(true).create(true).open(path).map_err(failed)?;
        lock_for_writing(&file, || {
            format!("another sweep is writing {}: wait for it, or choose another --out", path.display())
        })?;
        file.read_to_string(&mut old).map_err(|error| unreadable(path, &error))?;
        form.take(path, &old, &mut rows)
            .map_err(|failure| Failure::new(failure.exit, format!("{}; choose another --out", failure.message)))?;
        match whole(&old).len() {
            length if length >= form.begin.len() => file.set_len(length as u64).map_err(failed)?,
            _ => file.set_len(0).and_then(|()| file.write_all(form.begin.as_bytes())).map_err(failed)?,
        }
        Ok(Table { path: path.into(), form, growing: Mutex::new((file, rows)) })
    }

    /// Whether a run has a row.
    pub fn has(&self, number: usize) -> bool {
        self.growing.lock().unwrap_or_else(PoisonError::into_inner).1[number].is_some()
    }

    /// Adds the results of a run, also to the file.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn append(&self, number: usize, results: &[String]) -> Result<(), Failure> {
        let row = self.form.row(number, results);
        let mut growing = self.growing.lock().unwrap_or_else(PoisonError::into_inner);
        growing.0.write_all(row.line.as_bytes()).map_err(|error| write_failure(&self.path, &error))?;
        growing.1[number] = Some(row);
        Ok(())
    }

    /// Sorts the file and returns the rows.
    ///
    /// # Errors
    /// If the table cannot be written.
    pub fn finish(self) -> Result<Vec<Option<Row>>, Failure> {
        let rows = self.growing.into_inner().unwrap_or_else(PoisonError::into_inner).1;
        let text = self.form.text(rows.iter().flatten());
        write_atomically(&self.path, &text).map_err(|error| write_failure(&self.path, &error))?;
        Ok(rows)
    }
}

/// The rows of several tables of one batch.
///
/// # Errors
/// A file of another batch, rows that contradict each other, or a run without a row.
pub fn merge(paths: &[PathBuf], form: &Form) -> Result<Vec<Row>, Failure> {
    let mut rows = vec![None; form.keys.len()];
    for path in paths {
        let text = messages::file::text(path).map_err(|error| unreadable(path, &error))?;
        form.take(path, &text, &mut rows)?;
    }
    let missing = rows.iter().filter(|row| row.is_none()).count();
    match rows.iter().position(Option::is_none) {
        None => Ok(rows.into_iter().flatten().collect()),
        Some(first) => {
            let message = format!("{missing} of {} runs are in none of the files, run {first} among them", rows.len());
            Err(Failure::new(Exit::Usage, message))
        }
    }
}

/// The text without an incomplete last row.
fn whole(text: &str) -> &str {
    text.rfind('\n').map_or("", |end| &text[..=end])
}

fn unreadable(path: &Path, error: &std::io::Error) -> Failure {
    Failure::new(Exit::Usage, format!("{} cannot be read: {error}", path.display()))
}
