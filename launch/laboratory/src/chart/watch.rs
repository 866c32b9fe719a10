//! Progress of the chart, and the flag that stops it.

use shared::exit::{Failure, check_interrupt};
use shared::progress::BatchProgress;
use std::sync::atomic::AtomicBool;

/// The stage of the measurement, for the progress display.
#[derive(Clone, Copy, Debug)]
pub enum Job {
    /// A run, for its errors.
    Watching,
    /// A run, for its time.
    Timing,
    /// A run that may fail.
    Failing,
    /// A threshold, by bisection.
    Bisecting,
    /// A model of another size.
    Sizing,
}

/// The progress display and the flag that stops the measurement.
pub struct ChartProgress<'a> {
    counter: BatchProgress,
    /// Whether the user wants to stop.
    pub stop: &'a AtomicBool,
}

impl<'a> ChartProgress<'a> {
    /// Progress with no runs planned yet.
    pub fn new(quiet: bool, stop: &'a AtomicBool) -> ChartProgress<'a> {
        ChartProgress { counter: BatchProgress::new(quiet, 0, 0, "runs"), stop }
    }

    /// Adds planned runs.
    pub fn expect(&self, runs: usize) {
        self.counter.add_total(runs);
    }

    /// Counts the start of a run.
    ///
    /// # Errors
    /// Ctrl-C.
    pub fn step(&self, job: Job) -> Result<(), Failure> {
        self.counter.set_activity(&format!("{job:?}").to_lowercase());
        self.counter.add_done(1);
        check_interrupt(self.stop)
    }

    /// Prints a line beside the progress bar.
    pub fn log(&self, line: &str) {
        self.counter.log(line);
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.counter.finish();
    }
}
