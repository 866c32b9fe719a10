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

use self::core::Core;
use crate::exit::{Failure, unless};
use crate::output::{folder, say, tell, unwritten, write_whole};
use clap::Args;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use std::io::IsTerminal;
use std::path::PathBuf;
use std::sync::Mutex;
use std::sync::atomic::AtomicBool;
use std::time::{Duration, Instant};

/// Arguments of `biped chart`.
#[derive(Args)]
pub struct ChartArgs {
    /// Write the table, the drawings and the page into this folder
    #[arg(long, value_name = "DIR", default_value = "out/chart")]
    out: PathBuf,
    /// Few and coarse steps: every drawing within a minute
    #[arg(long)]
    quick: bool,
    /// Also measure other engines, installed into a Python virtual environment; or read a table or a folder of their runs
    #[arg(long, value_name = "PATH", num_args = 0..=1, require_equals = true)]
    peers: Option<Option<PathBuf>>,
    /// Instead: how the time of a step grows with contacts, links and step length, and the throughput of several processors
    #[arg(long)]
    growth: bool,
    /// Instead: order, error and cost of every integration method in each kind of motion
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
    folder(&args.out)?;
    let failed = |error| unwritten(&args.out, &error);
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
        write_whole(&args.out.join("chart.csv"), &csv::table(rows))
    };
    let alone = "Other simulators are not drawn: biped chart --peers measures them too.".to_string();
    let remarks = match &args.peers {
        None => vec![alone],
        Some(None) => {
            write(&rows, &[alone]).map_err(failed)?; // the measurement takes minutes and may fail
            let (found, left_out) = peers::rows(&args.out, &chosen, args.quick, &watch)?;
            rows.extend(found);
            [vec![peers::REMARK.into()], left_out].concat()
        }
        Some(Some(table)) => {
            rows.extend(given);
            let origin = format!("Other simulators are those of {}, measured in another session.", table.display());
            vec![origin, peers::REMARK.into()]
        }
    };
    watch.bar.finish_and_clear();
    write(&rows, &remarks).map_err(failed)?;
    say(format!(
        "{} measurements in {}, drawn in chart.html beside it; {:.0} s\n",
        rows.len(),
        args.out.join("chart.csv").display(),
        begun.elapsed().as_secs_f64(),
    ));
    say(crate::study::table(&bounds::table(&chosen, &rows)));
    Ok(())
}

/// The stage of the measurement, for the progress display.
#[derive(Clone, Copy, Debug)]
enum Job {
    Watching,
    Timing,
    Failing,
    Bisecting,
    Sizing,
}

/// The progress display and the flag that stops the measurement.
struct Watch<'a> {
    bar: ProgressBar,
    lines: bool,
    told: Mutex<Instant>,
    stop: &'a AtomicBool,
}

impl<'a> Watch<'a> {
    fn new(quiet: bool, stop: &'a AtomicBool) -> Watch<'a> {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal && !quiet { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(0), target);
        if let Ok(style) = ProgressStyle::with_template("[{bar:24}] {pos} of {len} runs, {elapsed}, {msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        Watch { bar, lines: !terminal && !quiet, told: Mutex::new(Instant::now()), stop }
    }

    /// Adds `runs` to the number of expected runs.
    fn expect(&self, runs: usize) {
        self.bar.inc_length(runs as u64);
    }

    /// Counts a run that starts.
    fn step(&self, job: Job) -> Result<(), Failure> {
        self.bar.inc(1);
        self.bar.set_message(format!("{job:?}").to_lowercase());
        if let Ok(mut told) = self.told.lock()
            && self.lines
            && told.elapsed() > Duration::from_secs(5)
        {
            *told = Instant::now();
            tell(format_args!("{} of {} runs, {job:?}", self.bar.position(), self.bar.length().unwrap_or(0)));
        }
        unless(self.stop)
    }

    /// Prints a line above the progress bar.
    fn tell(&self, line: &str) {
        match self.lines {
            true => tell(line),
            false => self.bar.println(line),
        }
    }
}
