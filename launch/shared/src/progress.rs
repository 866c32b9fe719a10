//! Progress on standard error: a bar on a terminal, plain lines elsewhere.

use crate::output::log;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use messages::scene::Scene;
use messages::wire::{PHASES, Truth};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time between two plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Time between two updates of the bar of a run.
const BAR_INTERVAL: Duration = Duration::from_millis(100);
/// Simulated time over which the displayed speed is averaged: about the period of two steps [s].
const SPEED_WINDOW: f64 = 0.6;
/// Lower bound of the elapsed time in the displayed ratio of simulated to real time, against division by zero [s].
const MIN_ELAPSED: f64 = 1e-3;

/// Progress of one run.
pub struct RunProgress {
    /// The bar; hidden without a terminal. Print other lines inside its `suspend`.
    pub bar: ProgressBar,
    has_lines: bool,
    duration: f64,
    start: Instant,
    last_shown: Instant,
    /// Start of the window of the speed: simulated time [s] and x of the base [m].
    window_start: (f64, f64),
    speed: f64,
}

impl RunProgress {
    /// Progress of a run of `scene`, which begins now.
    pub fn new(scene: &Scene, quiet: bool) -> RunProgress {
        // The bar counts milliseconds. It has no colours, so NO_COLOR needs no handling.
        let (bar, has_lines) = bar(quiet, (scene.duration * 1e3) as u64, "[{bar:10}] {percent:>3} %  {wide_msg}");
        let now = Instant::now();
        let (duration, window_start) = (scene.duration, (0.0, 0.0));
        RunProgress { bar, has_lines, duration, start: now, last_shown: now, window_start, speed: 0.0 }
    }

    /// Updates the speed from the truth of a control period. Call it every period; it is cheap.
    pub fn update(&mut self, truth: &Truth) {
        let (time, x) = (truth.stamp.time(), truth.base_position[0]);
        if time == 0.0 {
            self.window_start = (time, x);
        }
        if time - self.window_start.0 >= SPEED_WINDOW {
            self.speed = (x - self.window_start.1) / (time - self.window_start.0);
            self.window_start = (time, x);
        }
    }

    /// Shows the latest truth, unless the last update was too recent.
    pub fn show(&mut self, truth: &Truth) {
        let interval = if self.has_lines { LINE_INTERVAL } else { BAR_INTERVAL };
        if self.last_shown.elapsed() < interval || (self.bar.is_hidden() && !self.has_lines) {
            return;
        }
        self.last_shown = Instant::now();
        self.bar.set_position(truth.stamp.sim_ns / 1_000_000);
        self.bar.set_message(self.line(truth));
        if self.has_lines {
            log(self.line(truth));
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn line(&self, truth: &Truth) -> String {
        let time = truth.stamp.time();
        let telemetry = &truth.telemetry;
        let phase = PHASES.get(telemetry.phase as usize).copied().unwrap_or("?");
        let support = if telemetry.support == 0 { "left" } else { "right" };
        format!(
            "t {time:.1}/{:.1} s  {:.0}x  x {:+.2} m  {:+.2} m/s  {phase}, {support} foot",
            self.duration,
            time / self.start.elapsed().as_secs_f64().max(MIN_ELAPSED),
            truth.base_position[0],
            self.speed,
        )
    }
}

/// A bar, which is visible on a terminal only; and whether plain lines replace it.
fn bar(quiet: bool, length: u64, template: &str) -> (ProgressBar, bool) {
    let is_terminal = std::io::stderr().is_terminal();
    let target = if is_terminal && !quiet { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    (bar, !is_terminal && !quiet)
}

/// Progress of a batch of runs or measurements.
pub struct BatchProgress {
    /// The bar; hidden without a terminal. Print other lines inside its `suspend`.
    pub bar: ProgressBar,
    /// Plural of the counted items.
    items: &'static str,
    /// When the last plain line was printed; `None` if there are no plain lines, because of a bar or `--quiet`.
    last_line: Option<Mutex<Instant>>,
}

impl BatchProgress {
    /// Progress of `total` items, of which `done` are done already. `items` is their plural.
    pub fn new(quiet: bool, total: usize, done: usize, items: &'static str) -> BatchProgress {
        let template = format!("[{{bar:24}}] {{pos}} of {{len}} {items}, {{elapsed}}, {{eta}} to go{{msg}}");
        let (bar, has_lines) = bar(quiet, total as u64, &template);
        bar.set_position(done as u64);
        bar.reset_eta();
        BatchProgress { bar, items, last_line: has_lines.then(|| Mutex::new(Instant::now())) }
    }

    /// Increases the total.
    pub fn add_total(&self, more: usize) {
        self.bar.inc_length(more as u64);
    }

    /// Counts items as done.
    pub fn add_done(&self, more: u64) {
        self.set_done(self.bar.position() + more);
    }

    /// Sets the number of items that are done.
    pub fn set_done(&self, count: u64) {
        self.bar.set_position(count);
        if let Some(Ok(mut last_line)) = self.last_line.as_ref().map(Mutex::lock)
            && last_line.elapsed() > LINE_INTERVAL
        {
            *last_line = Instant::now();
            let (done, total, activity) = (self.bar.position(), self.bar.length().unwrap_or(0), self.bar.message());
            log(format_args!("{done} of {total} {}{activity}", self.items));
        }
    }

    /// Shows the current activity beside the count.
    pub fn set_activity(&self, activity: &str) {
        self.bar.set_message(format!(", {activity}"));
    }

    /// Prints a line above the bar, or a plain line.
    pub fn log(&self, line: &str) {
        match self.last_line {
            Some(_) => log(line),
            None => self.bar.println(line),
        }
    }

    /// Prints a plain line; nothing where the bar shows the activity.
    pub fn log_without_bar(&self, line: &str) {
        if self.last_line.is_some() {
            log(line);
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
