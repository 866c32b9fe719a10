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
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal && !quiet { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        // Milliseconds; no colours, so that there is nothing for NO_COLOR to switch off.
        let bar = ProgressBar::with_draw_target(Some((scene.duration * 1e3) as u64), target);
        if let Ok(style) = ProgressStyle::with_template("[{bar:10}] {percent:>3} %  {wide_msg}") {
            bar.set_style(style.progress_chars("=> "));
        }
        let now = Instant::now();
        let lines = !terminal && !quiet;
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

/// The progress of many runs, on standard error: a bar on a terminal, plain lines elsewhere.
pub struct Counter {
    bar: ProgressBar,
    what: &'static str,
    /// When the last plain line was printed; none are where there is a bar, or silence.
    told: Option<Mutex<Instant>>,
}

impl Counter {
    /// So many are to be done, and so many are done already.
    pub fn new(quiet: bool, length: usize, done: usize, what: &'static str) -> Counter {
        let terminal = std::io::stderr().is_terminal();
        let target = if terminal && !quiet { ProgressDrawTarget::stderr() } else { ProgressDrawTarget::hidden() };
        let bar = ProgressBar::with_draw_target(Some(length as u64), target).with_position(done as u64);
        let template = format!("[{{bar:24}}] {{pos}} of {{len}} {what}, {{elapsed}}, {{eta}} to go");
        if let Ok(style) = ProgressStyle::with_template(&template) {
            bar.set_style(style.progress_chars("=> "));
        }
        bar.reset_eta();
        Counter { bar, what, told: (!terminal && !quiet).then(|| Mutex::new(Instant::now())) }
    }

    /// One more is done.
    pub fn step(&self) {
        self.reach(self.bar.position() + 1);
    }

    /// So many are done.
    pub fn reach(&self, count: u64) {
        self.bar.set_position(count);
        if let Some(Ok(mut told)) = self.told.as_ref().map(Mutex::lock)
            && told.elapsed() > LINE_INTERVAL
        {
            *told = Instant::now();
            tell(format_args!("{} of {} {}", self.bar.position(), self.bar.length().unwrap_or(0), self.what));
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.finish_and_clear();
    }
}
