//! `biped chart`: speed against accuracy of every contact law, integrator and model size, and where each of them fails.
//!
//! | view | what | where |
//! |---|---|---|
//! | (i) | error against CPU time per simulated second | [`precision`] |
//! | (ii) | CPU time per step of 1 ms | [`steps`] |
//! | (iii) | where methods fail, and the thresholds of failure | [`failures`], [`thresholds`] |
//! | (iv) | size of the model against cost | [`models`] |
//! | `--orders` | order, error and cost of every integration method | [`orders`] |
//! | `--growth` | how the cost of a step grows | [`growth`] |
//!
//! Measurements become rows of one table ([`csv`]). Other engines add their rows ([`peers`]). All drawings ([`draw`], [`page`]) are
//! made from these rows alone.

mod args;
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
pub use args::ChartArgs;
pub use peers::files as peer_files;
use shared::exit::Failure;
use shared::output::{MARK, prepare_folder, print_text, write_atomically, write_failure};
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use watch::ChartProgress;

/// Creates the folder before the work, and checks that its files can be replaced.
fn prepare(args: &ChartArgs, chosen: &[cases::ComparisonScene]) -> Result<(), Failure> {
    let drawn = |names: Vec<String>| names.into_iter().map(|name| (format!("{name}.svg"), MARK)).collect::<Vec<_>>();
    let mut files = match (args.orders, args.growth) {
        (true, _) => vec![],
        (_, true) => drawn(growth::drawings()),
        _ => drawn(page::drawings(chosen)),
    };
    files.extend(match (args.orders, args.growth) {
        (true, _) => vec![("orders.csv".into(), "method,")],
        (_, true) => vec![("growth.csv".into(), "curve,")],
        _ => vec![("chart.csv".into(), csv::HEADER), ("chart.html".into(), MARK)],
    });
    if let Some(None) = args.peers {
        files.push(("peers.csv".into(), peers::HEAD));
    }
    prepare_folder(&args.out, &files)
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
    prepare(args, &chosen)?;
    let failed = |error| write_failure(&args.out, &error);
    let watch = ChartProgress::new(args.quiet, stop);
    if args.orders {
        return orders::run(&args.out, &watch);
    }
    if args.growth {
        return growth::run(args, &watch);
    }
    let trials = precision::trials(&chosen, args.quick, &watch)?;
    let mut rows: Vec<_> = trials.iter().flat_map(precision::MethodTrial::rows).collect();
    rows.extend(steps::measure(args.quick, &watch)?);
    rows.extend(failures::measure(&trials, &watch)?);
    rows.extend(thresholds::measure(&watch)?);
    rows.extend(models::measure(&watch)?);
    let held = Core::hold().remark();
    let write = |rows: &[csv::Measurement], remarks: &[String]| {
        let remark = [vec![held.clone()], remarks.to_vec()].concat().join(" ");
        page::write(&args.out, &chosen, rows, &remark)?;
        write_atomically(&args.out.join("chart.csv"), &csv::table(rows))
    };
    let alone = "Other simulators are not drawn: biped chart --peers measures them too.".to_string();
    let remarks = match &args.peers {
        None => vec![alone],
        Some(None) => {
            write(&rows, &[alone]).map_err(failed)?; // the measurement takes minutes and may fail
            let (found, left_out) = peers::measure(&args.out, &chosen, args.quick, &watch).map_err(|failure| {
                failure.keeping(format!("the chart in {} has no other simulators", args.out.display()))
            })?;
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
    print_text(crate::study::tables::table(&bounds::table(&chosen, &rows)));
    Ok(())
}
