//! `biped robustness`: a map of the delay, jitter and loss of commands with which the robot still walks.
//!
//! | what | where |
//! |---|---|
//! | the list of runs | [`grid`] |
//! | the columns of their results | [`results`] |
//! | results by cell | [`cells`] |
//! | the drawing, with the survival contour and the stability limit of the servos | [`map`] |
//! | shards, the table and its resumption | [`crate::batch`] |

mod args;
mod cells;
mod grid;
mod map;
mod results;

use crate::batch::Batch;
use crate::batch::table::{Form, Row};
use crate::study;
pub use args::RobustnessArgs;
use cells::Cells;
use grid::{LinkGrid, SweepRun};
use shared::exit::Failure;
use shared::output::{print_text, write_atomically, write_failure};
use std::sync::atomic::AtomicBool;

/// Does the runs that are missing from the table, then draws the map; with a shard or after Ctrl-C, only the table.
///
/// # Errors
/// Ctrl-C, a bad argument, tables that do not belong together, or a folder that cannot be written.
pub fn run(args: &RobustnessArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let grid = LinkGrid::new(args)?;
    let (cases, form) = (grid.cases(), grid.form());
    let batch = Batch { command: "robustness", args: &args.batch, out: &args.out, quiet: args.quiet, form: &form };
    let work = |number: usize| Ok(results::cells(&study::observe(&args.scene, &cases[number].scene(), stop)?));
    batch.rows(work)?.map_or(Ok(()), |rows| draw(args, &grid, &cases, &form, &rows))
}

/// Writes the whole table and the map, and prints a summary.
fn draw(args: &RobustnessArgs, grid: &LinkGrid, cases: &[SweepRun], form: &Form, rows: &[Row]) -> Result<(), Failure> {
    let cells = Cells::new(grid, cases, rows)?;
    let files = [("robustness.csv", form.text(rows)), ("robustness.svg", map::survival(grid, &cells))];
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
