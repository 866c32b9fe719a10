//! `biped robustness`: how much delay, jitter and loss of commands the walk bears, as a map.
//!
//! | what | where |
//! |---|---|
//! | which runs | [`grid`] |
//! | their table: written as it goes, resumed, merged | [`table`] |
//! | what came out, cell by cell | [`cells`] |
//! | the drawing, with the survival contour and the servo's own limit | [`map`] |
//!
//! Every run is a case with a number, the same in every shard; its row in the table depends on nothing else. So shards
//! that ran anywhere merge to the very file that one machine would have written.

mod cells;
mod grid;
mod map;
mod table;

use crate::study;
use cells::Cells;
use clap::Args;
use grid::{Case, Grid};
use rayon::prelude::*;
use shared::exit::{Exit, Failure};
use shared::output::{create_folder, print_text, write_atomically, write_failure};
use shared::progress::BatchProgress;
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
    /// Jitters, ascending; --set link.jitter=normal or =burst for another kind than uniform [ms]
    #[arg(long, value_name = "MS,…", value_delimiter = ',', allow_negative_numbers = true)]
    jitter: Vec<f64>,
    /// Probabilities that a command is lost, ascending
    #[arg(long, value_name = "P,…", value_delimiter = ',', allow_negative_numbers = true)]
    loss: Vec<f64>,
    /// Repeat the map for each value of a key, say plant.friction=0.7,0.3 or plant.payload_kg=0,2 or
    /// plant.push_impulse=[0,2,0],[0,-2,0]; given twice, for each combination
    #[arg(long, value_name = "KEY=V,…")]
    with: Vec<String>,
    /// Runs of each cell, every one with another seed
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1000))]
    seeds: Option<u64>,
    /// A coarse map of short walks, within seconds
    #[arg(long)]
    quick: bool,
    /// Do only the i-th of n equal shares of the runs
    #[arg(long, value_name = "I/N")]
    shard: Option<grid::Shard>,
    /// Do none, but put the tables of all shards together and draw the map; with the options that they were made with
    #[arg(long, value_name = "FILES", num_args = 1.., conflicts_with = "shard")]
    merge: Vec<PathBuf>,
    /// Write the table and the map into this folder; what its table has already is not done again
    #[arg(long, value_name = "DIR", default_value = "out/robustness")]
    out: PathBuf,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// Does the runs that are missing from the table, then draws the map; with a shard or after Ctrl-C, only the table.
///
/// # Errors
/// Ctrl-C, a bad wish, tables that do not belong together, or a folder that cannot be written.
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
            format!("interrupted: {count} of {} runs are in {}; the same command goes on", mine.len(), path.display()),
        ),
        _ => failure,
    })?;
    match args.shard {
        Some(_) => print_text(format!("{count} runs in {}; --merge puts the shards together\n", path.display())),
        None => draw(args, &grid, &cases, &rows)?,
    }
    Ok(())
}

/// Writes the whole table and the map, and says what they show.
fn draw(args: &RobustnessArgs, grid: &Grid, cases: &[Case], rows: &[Option<String>]) -> Result<(), Failure> {
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
