//! A batch of runs: the part that `biped robustness` and `biped sweep` share.
//!
//! | what | where |
//! |---|---|
//! | values of a key, and their combinations | [`axis`] |
//! | a share of the runs | [`shard`] |
//! | the table of results: appended to, resumed, merged | [`table`] |
//! | a map of survival with its contour | [`panel`] |
//!
//! Every run has a number that is the same in every shard. Its row in the table depends on nothing else. Shards from several
//! machines therefore merge into the same file that one machine would have written.

pub mod axis;
pub mod panel;
pub mod shard;
pub mod table;

use clap::Args;
use rayon::prelude::*;
use shard::Shard;
use shared::exit::{Exit, Failure};
use shared::output::{create_folder, print_text};
use shared::progress::BatchProgress;
use std::path::{Path, PathBuf};
use table::{Form, Row, Table};

/// Arguments of every batch.
#[derive(Args)]
pub struct BatchArgs {
    /// Run only the i-th of n equal shares
    #[arg(long, value_name = "I/N")]
    pub shard: Option<Shard>,
    /// Run nothing: merge the tables of all shards and draw the map; needs the options of the shards
    #[arg(long, value_name = "FILES", num_args = 1.., conflicts_with = "shard")]
    pub merge: Vec<PathBuf>,
}

/// A batch of runs.
pub struct Batch<'a> {
    /// Name of the command, which is also that of its files.
    pub command: &'static str,
    /// Its arguments.
    pub args: &'a BatchArgs,
    /// Folder of its files.
    pub out: &'a Path,
    /// Whether to show no progress.
    pub quiet: bool,
    /// Its table.
    pub form: &'a Form,
}

impl Batch<'_> {
    /// Does the runs that are missing from the table. `work` does the run with a number and returns its results. Returns all rows of the
    /// table. For a shard it returns `None`, because its table holds only a share of the rows.
    ///
    /// # Errors
    /// Ctrl-C, a failure of `work`, tables that do not belong together, or a folder that cannot be written.
    pub fn rows(
        &self,
        work: impl Fn(usize) -> Result<Vec<String>, Failure> + Sync,
    ) -> Result<Option<Vec<Row>>, Failure> {
        if !self.args.merge.is_empty() {
            let rows = table::merge(&self.args.merge, self.form)?;
            create_folder(self.out)?;
            return Ok(Some(rows));
        }
        create_folder(self.out)?;
        let shard = self.args.shard;
        let name = shard.map_or(format!("{}.csv", self.command), |shard| shard.file_name(self.command));
        let path = self.out.join(name);
        let mine: Vec<usize> =
            (0..self.form.keys.len()).filter(|number| shard.is_none_or(|shard| shard.has(*number))).collect();
        let table = Table::resume(&path, self.form)?;
        let missing: Vec<usize> = mine.iter().copied().filter(|number| !table.has(*number)).collect();
        let counter = BatchProgress::new(self.quiet, mine.len(), mine.len() - missing.len(), "runs");
        let done = missing.par_iter().try_for_each(|&number| {
            table.append(number, &work(number)?)?;
            counter.add_done(1);
            Ok(())
        });
        counter.finish();
        let rows = table.finish()?;
        let count = mine.iter().filter(|number| rows[**number].is_some()).count();
        done.map_err(|failure: Failure| match failure.exit {
            Exit::Interrupted => Failure::new(
                Exit::Interrupted,
                format!(
                    "interrupted: {count} of {} runs are in {}; run the same command again to go on",
                    mine.len(),
                    path.display()
                ),
            ),
            _ => failure,
        })?;
        if shard.is_some() {
            print_text(format!("{count} runs in {}; --merge merges the shards\n", path.display()));
            return Ok(None);
        }
        Ok(Some(rows.into_iter().flatten().collect()))
    }
}
