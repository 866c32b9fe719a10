//! `biped robustness`: a map of the delay, jitter and loss of commands with which the robot still walks.
//!
//! | what | where |
//! |---|---|
//! | the list of runs | [`grid`] |
//! | their table: appended to, resumed, merged | [`table`] |
//! | results by cell | [`cells`] |
//! | the drawing, with the survival contour and the stability limit of the servos | [`map`] |
//!
//! Every run is a case with a number that is the same in every shard. Its row in the table depends on nothing else. Shards from
//! several machines therefore merge into the same file that one machine would have written.

mod args;
mod cells;
mod grid;
mod map;
mod shard;
mod table;

use crate::study;
pub use args::RobustnessArgs;
use cells::Cells;
use grid::{Grid, SweepRun};
use rayon::prelude::*;
use shared::exit::{Exit, Failure};
use shared::output::{create_folder, print_text, write_atomically, write_failure};
use shared::progress::BatchProgress;
use std::sync::atomic::AtomicBool;
use table::Table;

/// Does the runs that are missing from the table, then draws the map; with a shard or after Ctrl-C, only the table.
///
/// # Errors
/// Ctrl-C, a bad argument, tables that do not belong together, or a folder that cannot be written.
pub fn run(args: &RobustnessArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let grid = Grid::new(args)?;
    let cases = grid.cases();
    if !args.merge.is_empty() {
        let rows = table::merge(&args.merge, &grid, &cases)?;
        create_folder(&args.out)?;
        return draw(args, &grid, &cases, &rows);
    }
    create_folder(&args.out)?;
    let path = args.out.join(args.shard.map_or("robustness.csv".into(), |shard| shard.file_name()));
    let mine: Vec<_> = cases.iter().filter(|case| args.shard.is_none_or(|shard| shard.has(case.number))).collect();
    let table = Table::resume(&path, &grid, &cases)?;
    let missing: Vec<_> = mine.iter().copied().filter(|case| !table.has(case.number)).collect();
    let counter = BatchProgress::new(args.quiet, mine.len(), mine.len() - missing.len(), "runs");
    let done = missing.par_iter().try_for_each(|case| {
        let outcome = study::observe(&args.scene, &case.scene(), stop)?;
        table.append(case, &outcome)?;
        counter.add_done(1);
        Ok(())
    });
    counter.finish();
    let rows = table.finish()?;
    let count = mine.iter().filter(|case| rows[case.number].is_some()).count();
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
    match args.shard {
        Some(_) => print_text(format!(
            "{count} runs in {}; --merge merges the shards
",
            path.display()
        )),
        None => draw(args, &grid, &cases, &rows)?,
    }
    Ok(())
}

/// Writes the whole table and the map, and prints a summary.
fn draw(args: &RobustnessArgs, grid: &Grid, cases: &[SweepRun], rows: &[Option<String>]) -> Result<(), Failure> {
    let cells = Cells::new(grid, cases, rows)?;
    let files = [("robustness.csv", table::text(grid, rows)), ("robustness.svg", map::survival(grid, &cells))];
    for (name, text) in files {
        let path = args.out.join(name);
        write_atomically(&path, &text).map_err(|error| write_failure(&path, &error))?;
    }
    print_text(cells.summary(grid));
    print_text(format!(
        "{} runs in {}, drawn in robustness.svg beside it\n",
        cases.len(),
        args.out.join("robustness.csv").display()
    ));
    Ok(())
}
