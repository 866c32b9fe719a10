//! `biped sweep`: runs of a scene with every combination of values of some keys.
//!
//! | what | where |
//! |---|---|
//! | the arguments' keys and values; the list of runs | [`keys`], [`grid`] |
//! | the columns of their results, and the condition of survival | [`figures`] |
//! | thresholds of survival, by bisection | [`edge`] |
//! | the drawing of one key; of two or more | [`curve`], [`map`] |
//! | the table as Parquet | [`parquet`] |
//! | shards, the table and its resumption | [`crate::batch`] |

mod args;
mod curve;
mod edge;
mod figures;
mod grid;
mod keys;
mod map;
mod parquet;

use crate::batch::Batch;
use crate::study;
pub use args::SweepArgs;
use figures::Survival;
use grid::Grid;
use shared::csv;
use shared::exit::{Exit, Failure};
use shared::output::{log, print_text, write_atomically, write_failure};
use std::sync::atomic::AtomicBool;

/// Does the runs that are missing from the table, finds thresholds, writes tables and the figure, and prints a summary. With a shard or
/// after Ctrl-C, only the table is written.
///
/// # Errors
/// Ctrl-C, a bad argument, tables that do not belong together, or a folder that cannot be written.
pub fn run(args: &SweepArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let survival = args.survival.as_deref();
    let survival = Survival::parse(survival)
        .map_err(|words| Failure::new(Exit::Usage, format!("--survival {}: {words}", survival.unwrap_or_default())))?;
    let grid = Grid::new(args)?;
    let tolerance = args.edge.as_ref().map(|_| edge::tolerance(args.tolerance, &grid)).transpose()?;
    let batch = Batch { command: "sweep", args: &args.batch, out: &args.out, quiet: args.quiet, form: &grid.form };
    let work = |number: usize| {
        let scene = grid.scene(&grid.settings(&grid.runs[number]))?;
        Ok(figures::cells(&study::observe(&args.scene.scene, &scene, stop)?, &scene))
    };
    let Some(rows) = batch.rows(work)? else { return Ok(()) };
    let edges = tolerance
        .map(|tolerance| edge::find(&grid, &survival, &rows, tolerance, &args.out, args.quiet, stop))
        .transpose()?;
    let figure = match grid.drawn().0.len() {
        1 => curve::draw(&grid, &survival, &rows, edges.as_deref().unwrap_or_default()),
        _ => map::draw(&grid, &survival, &rows, edges.as_deref().unwrap_or_default()),
    };
    let mut files = vec![("sweep.csv", grid.form.text(&rows)), ("sweep.svg", figure)];
    files.extend(edges.as_ref().map(|edges| ("edges.csv", edge::table(&grid, edges))));
    for (name, text) in files {
        let path = args.out.join(name);
        write_atomically(&path, &text).map_err(|error| write_failure(&path, &error))?;
    }
    let path = args.out.join("sweep.parquet");
    let cells = csv::rows(&grid.form.text(&rows)).map_err(|words| write_failure(&path, &words))?;
    parquet::write(&path, &cells).map_err(|error| write_failure(&path, &error))?;
    for outcome in [figures::REFUSED, figures::FAILED] {
        let with_it = figures::with_outcome(&rows, outcome);
        if let Some((first, row)) = with_it.first() {
            let (count, words) = (with_it.len(), figures::reason(row));
            log(format_args!("{outcome} runs: {count}, see the column `{}`; run {first}: {words}", figures::ERROR));
        }
    }
    let survives: Vec<bool> = rows.iter().map(|row| survival.holds(&row.results)).collect();
    if let Some(edges) = edges {
        print_text(edge::summary(&grid, &edges, &survives));
    }
    let survivors = survives.iter().filter(|survives| **survives).count();
    let refused = figures::with_outcome(&rows, figures::REFUSED).len();
    let remark = if refused > 0 { format!(", {refused} refused") } else { String::new() };
    let (done, table) = (rows.len() - refused, args.out.join("sweep.csv"));
    print_text(format!(
        "{survivors} of {done} runs survive{remark}: {}, drawn in sweep.svg beside it\n",
        table.display()
    ));
    Ok(())
}
