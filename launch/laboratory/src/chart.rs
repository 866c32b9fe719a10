//! `biped chart`: speed against accuracy of every contact law, integrator and model size, and where each of them fails.
//!
//! | view | what | where |
//! |---|---|---|
//! | (i) | error against CPU time per simulated second | [`precision`] |
//! | (ii) | CPU time per step of 1 ms | [`steps`] |
//! | (iii) | where methods fail, and from where on | [`failures`], [`thresholds`] |
//! | (iv) | size of the model against cost | [`models`] |
//! | `--orders` | order, error and cost of every integration method | [`orders`] |
//! | `--growth` | how the cost of a step grows | [`growth`] |
//!
//! Measurements become rows of one table ([`csv`]), to which other engines add theirs ([`peers`]); everything that is
//! drawn ([`draw`], [`page`]) is drawn from these rows alone.

mod bounds;
mod cases;
mod core;
mod csv;
mod draw;
mod exact;
mod failures;
mod growth;
mod metrics;
mod models;
mod orders;
mod page;
mod peers;
mod precision;
mod steps;
mod thresholds;
mod trial;
mod watch;

use self::core::Core;
use clap::Args;
use shared::exit::Failure;
use shared::output::{create_folder, print_text, write_atomically, write_failure};
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use watch::Watch;

/// Arguments of `biped chart`.
#[derive(Args)]
pub struct ChartArgs {
    /// Write the table, the drawings and the page into this folder
    #[arg(long, value_name = "DIR", default_value = "out/chart")]
    out: PathBuf,
    /// Coarse steps and few of them: everything is drawn, within a minute
    #[arg(long)]
    quick: bool,
    /// Measure other engines too, installed into a virtual environment of Python; or take the rows of a table of them
    #[arg(long, value_name = "FILE", num_args = 0..=1, require_equals = true)]
    peers: Option<Option<PathBuf>>,
    /// Instead of all that: how the time of a step grows with contacts, links and step length, and what processors bring
    #[arg(long)]
    growth: bool,
    /// Instead of all that: order, error and cost of every integration method in each kind of motion
    #[arg(long, conflicts_with_all = ["growth", "peers"])]
    orders: bool,
    /// Only these comparison scenes, separated by commas
    #[arg(long, value_name = "NAMES", value_delimiter = ',')]
    scenes: Vec<String>,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
}

/// Measures everything and draws it.
///
/// # Errors
/// Ctrl-C, an unknown scene, or a folder that cannot be written.
pub fn run(args: &ChartArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let begun = Instant::now();
    let chosen = cases::chosen(&args.scenes)?;
    let table = args.peers.as_ref().and_then(Option::as_deref);
    let given = table.map_or(Ok(vec![]), peers::read)?;
    create_folder(&args.out)?;
    let failed = |error| write_failure(&args.out, &error);
    let watch = Watch::new(args.quiet, stop);
    if args.orders {
        return orders::run(&args.out, &watch);
    }
    if args.growth {
        return growth::run(args, &watch);
    }
    let trials = precision::trials(&chosen, args.quick, &watch)?;
    let mut rows: Vec<_> = trials.iter().flat_map(precision::Trial::rows).collect();
    rows.extend(steps::rows(args.quick, &watch)?);
    rows.extend(failures::rows(&trials, &watch)?);
    rows.extend(thresholds::rows(&watch)?);
    rows.extend(models::rows(&watch)?);
    let held = Core::hold().remark();
    let write = |rows: &[csv::Row], remarks: &[String]| {
        let remark = [vec![held.clone()], remarks.to_vec()].concat().join(" ");
        page::write(&args.out, &chosen, rows, &remark)?;
        write_atomically(&args.out.join("chart.csv"), &csv::table(rows))
    };
    let alone = "Other simulators are not drawn: biped chart --peers measures them too.".to_string();
    let remarks = match &args.peers {
        None => vec![alone],
        Some(None) => {
            write(&rows, &[alone]).map_err(failed)?; // what follows takes minutes, and may fail
            let (found, left_out) = peers::rows(&args.out, &args.scenes, args.quick, &watch)?;
            rows.extend(found);
            [vec![peers::REMARK.into()], left_out].concat()
        }
        Some(Some(table)) => {
            rows.extend(given);
            let origin = format!("Other simulators are those of {}, measured in another session.", table.display());
            vec![origin, peers::REMARK.into()]
        }
    };
    watch.finish();
    write(&rows, &remarks).map_err(failed)?;
    print_text(format!(
        "{} measurements in {}, drawn in chart.html beside it; {:.0} s\n",
        rows.len(),
        args.out.join("chart.csv").display(),
        begun.elapsed().as_secs_f64(),
    ));
    print_text(crate::study::table(&bounds::table(&chosen, &rows)));
    Ok(())
}
