//! What a run shows while it runs: a bar with a live line on a terminal, plain lines elsewhere.

use crate::output::tell;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use messages::scene::Scene;
use messages::wire::{PHASES, Truth};
use std::io::IsTerminal;
use std::sync::Mutex;
use std::time::{Duration, Instant};

/// Time between plain lines.
const LINE_INTERVAL: Duration = Duration::from_secs(5);
/// Simulated time over which the speed shown is averaged: about two steps [s].
const SPEED_SPAN: f64 = 0.6;

/// The progress of a run, on standard error.
pub struct Progress {
    /// The bar, hidden when there is no terminal; other lines go through its `suspend`.
    pub bar: ProgressBar,
    lines: bool,
    duration: f64,
    start: Instant,
    told: Instant,
    /// Time and place of the base that the speed counts from [s, m].
    from: (f64, f64),
    speed: f64,
}

impl Progress {
    /// A run of `scene` begins.
    pub fn new(scene: &Scene, quiet: bool) -> Progress {
        // Milliseconds; no colours, so that there is nothing for NO_COLOR to switch off.
        let (bar, lines) = bar(quiet, (scene.duration * 1e3) as u64, "[{bar:10}] {percent:>3} %  {wide_msg}");
        let now = Instant::now();
        Progress { bar, lines, duration: scene.duration, start: now, told: now, from: (0.0, 0.0), speed: 0.0 }
    }

    /// Takes the latest truth; cheap enough for every one of them.
    pub fn update(&mut self, truth: &Truth) {
        let (time, x) = (truth.stamp.sim_ns as f64 * 1e-9, truth.base_position[0]);
        if time == 0.0 {
            self.from = (time, x);
        }
        if time - self.from.0 >= SPEED_SPAN {
            self.speed = (x - self.from.1) / (time - self.from.0);
            self.from = (time, x);
        }
    }

    /// Shows the latest truth, when it is time to.
    pub fn show(&mut self, truth: &Truth) {
        let interval = if self.lines { LINE_INTERVAL } else { Duration::from_millis(100) };
        if self.told.elapsed() < interval || (self.bar.is_hidden() && !self.lines) {
            return;
        }
        self.told = Instant::now();
        self.bar.set_position(truth.stamp.sim_ns / 1_000_000);
        self.bar.set_message(self.line(truth));
        if self.lines {
            tell(self.line(truth));
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }

    fn line(&self, truth: &Truth) -> String {
        let time = truth.stamp.sim_ns as f64 * 1e-9;
        let telemetry = &truth.telemetry;
        let phase = PHASES.get(telemetry.phase as usize).copied().unwrap_or("?");
        let support = if telemetry.support == 0 { "left" } else { "right" };
        format!(
            "t {time:.1}/{:.1} s  {:.0}x  x {:+.2} m  {:+.2} m/s  {phase}, {support} foot",
            self.duration,
            time / self.start.elapsed().as_secs_f64().max(1e-3),
            truth.base_position[0],
            self.speed,
        )
    }
}

/// A bar on a terminal, hidden elsewhere; and whether plain lines take its place.
fn bar(quiet: bool, length: u64, template: &str) -> (ProgressBar, bool) {
    let is_terminal = std::io::stderr().is_terminal();
    let target = if is_terminal && !quiet { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
    let bar = ProgressBar::with_draw_target(Some(length), target);
    if let Ok(style) = ProgressStyle::with_template(template) {
        bar.set_style(style.progress_chars("=> "));
    }
    (bar, !is_terminal && !quiet)
}

/// The progress of many runs, on standard error: a bar on a terminal, plain lines elsewhere.
pub struct Counter {
    /// The bar, hidden when there is no terminal; lines of others go through its `suspend`.
    pub bar: ProgressBar,
    what: &'static str,
    /// When the last plain line was printed. There are none beside a bar, or if the user wants silence.
    told: Option<Mutex<Instant>>,
}

impl Counter {
    /// `length` of them are to be done, and `done` of them are done already; `what` is their plural.
    pub fn new(quiet: bool, length: usize, done: usize, what: &'static str) -> Counter {
        let template = format!("[{{bar:24}}] {{pos}} of {{len}} {what}, {{elapsed}}, {{eta}} to go{{msg}}");
        let (bar, lines) = bar(quiet, length as u64, &template);
        bar.set_position(done as u64);
        bar.reset_eta();
        Counter { bar, what, told: lines.then(|| Mutex::new(Instant::now())) }
    }

    /// More are to be done.
    pub fn expect(&self, more: usize) {
        self.bar.inc_length(more as u64);
    }

    /// More are done.
    pub fn add(&self, more: u64) {
        self.reach(self.bar.position() + more);
    }

    /// So many are done.
    pub fn reach(&self, count: u64) {
        self.bar.set_position(count);
        if let Some(Ok(mut told)) = self.told.as_ref().map(Mutex::lock)
            && told.elapsed() > LINE_INTERVAL
        {
            *told = Instant::now();
            let (done, all, doing) = (self.bar.position(), self.bar.length().unwrap_or(0), self.bar.message());
            tell(format_args!("{done} of {all} {}{doing}", self.what));
        }
    }

    /// Shows what is being done.
    pub fn show(&self, doing: &str) {
        self.bar.set_message(format!(", {doing}"));
    }

    /// Tells something beside the bar.
    pub fn tell(&self, line: &str) {
        match self.told {
            Some(_) => tell(line),
            None => self.bar.println(line),
        }
    }

    /// Tells something where there is no bar that shows it.
    pub fn tell_without_bar(&self, line: &str) {
        if self.told.is_some() {
            tell(line);
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
