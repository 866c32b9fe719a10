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

mod cells;
mod grid;
mod map;
mod table;

use crate::exit::{Exit, Failure};
use crate::output::{folder, say, unwritten, write_whole};
use crate::progress::Counter;
use crate::study;
use cells::Cells;
use clap::Args;
use grid::{Case, Grid};
use rayon::prelude::*;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use table::Table;

/// Arguments of `biped robustness`.
#[derive(Args)]
pub struct RobustnessArgs {
    /// Scene whose commands are disturbed
    #[arg(default_value = "walk")]
    scene: String,
    /// Replace a value of the scene (see `biped list --keys`); repeatable
    #[arg(long = "set", value_name = "KEY=VALUE")]
    settings: Vec<String>,
    /// Delays of every command, ascending [ms]
    #[arg(long, value_name = "MS,…", value_delimiter = ',', allow_negative_numbers = true)]
    delay: Vec<f64>,
    /// Jitters, ascending [ms]; their distribution is uniform, or that of --set link.jitter=normal or =burst
    #[arg(long, value_name = "MS,…", value_delimiter = ',', allow_negative_numbers = true)]
    jitter: Vec<f64>,
    /// Probabilities that a command is lost, ascending
    #[arg(long, value_name = "P,…", value_delimiter = ',', allow_negative_numbers = true)]
    loss: Vec<f64>,
    /// Repeat the map for each value of a key, for example plant.friction=0.7,0.3 or plant.payload_kg=0,2 or
    /// plant.push_impulse=[0,2,0],[0,-2,0]; if repeated, for each combination
    #[arg(long, value_name = "KEY=V,…")]
    with: Vec<String>,
    /// Runs of each cell, each with its own seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: Option<u64>,
    /// A coarse map of short walks: takes seconds
    #[arg(long)]
    quick: bool,
    /// Run only the i-th of n equal shares
    #[arg(long, value_name = "I/N")]
    shard: Option<grid::Shard>,
    /// Run nothing: merge the tables of all shards and draw the map; needs the options of the shards
    #[arg(long, value_name = "FILES", num_args = 1.., conflicts_with = "shard")]
    merge: Vec<PathBuf>,
    /// Write the table and the map into this folder; runs that its table has already are not repeated
    #[arg(long, value_name = "DIR", default_value = "out/robustness")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// Runs the cases that are missing in the table, then draws the map. With a shard, or after Ctrl-C, it writes only the table.
///
/// # Errors
/// Ctrl-C, a bad argument, tables that do not belong together, or a folder that cannot be written.
pub fn run(args: &RobustnessArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let grid = Grid::new(args)?;
    let cases = grid.cases();
    if !args.merge.is_empty() {
        let rows = table::merge(&args.merge, &grid, &cases)?;
        folder(&args.out)?;
        return draw(args, &grid, &cases, &rows);
    }
    folder(&args.out)?;
    let path = args.out.join(args.shard.map_or("robustness.csv".into(), |shard| shard.file_name()));
    let mine: Vec<_> = cases.iter().filter(|case| args.shard.is_none_or(|shard| shard.has(case.number))).collect();
    let table = Table::resume(&path, &grid, &cases)?;
    let missing: Vec<_> = mine.iter().copied().filter(|case| !table.has(case.number)).collect();
    let counter = Counter::new(args.quiet, mine.len(), mine.len() - missing.len(), "runs");
    let done = missing.par_iter().try_for_each(|case| {
        let outcome = study::observe(&args.scene, &case.scene(), stop)?;
        table.append(case, &outcome)?;
        counter.step();
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
        Some(_) => say(format!(
            "{count} runs in {}; --merge merges the shards
",
            path.display()
        )),
        None => draw(args, &grid, &cases, &rows)?,
    }
    Ok(())
}

/// Writes the whole table and the map, and prints a summary.
fn draw(args: &RobustnessArgs, grid: &Grid, cases: &[Case], rows: &[Option<String>]) -> Result<(), Failure> {
    let cells = Cells::new(grid, cases, rows)?;
    let files = [("robustness.csv", table::text(grid, rows)), ("robustness.svg", map::survival(grid, &cells))];
    for (name, text) in files {
        let path = args.out.join(name);
        write_whole(&path, &text).map_err(|error| unwritten(&path, &error))?;
    }
    say(cells.summary(grid));
    say(format!(
        "{} runs in {}, drawn in robustness.svg beside it\n",
        cases.len(),
        args.out.join("robustness.csv").display()
    ));
    Ok(())
}
