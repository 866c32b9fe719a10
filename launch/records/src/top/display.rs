//! The display of `biped top`: statistics of the records of a session, as lines.

use crate::summary::table::scientific;
use console::Style;
use messages::port::RecorderPort;
use messages::session::Session;
use messages::wire::{PHASES, REFUSALS, STATES, Truth};
use shared::exit::Failure;
use std::time::{Duration, Instant};

/// Interval between lines if the output is not a terminal.
pub(super) const LINE_INTERVAL: Duration = Duration::from_secs(1);
/// Time between reads of the session.
pub const POLL_INTERVAL: Duration = Duration::from_millis(2);

/// The reader of a session for its display.
pub(super) struct Display {
    port: RecorderPort,
    pub statistics: Interval,
}

impl Display {
    pub fn attach(session: &Session) -> Result<Display, Failure> {
        Ok(Display { port: RecorderPort::attach(session)?, statistics: Interval::new() })
    }

    /// Reads the session. At the end of an interval, returns its statistics, and begins another one.
    pub fn poll(&mut self, interval: Duration) -> Result<Option<Interval>, Failure> {
        while let Some(truth) = self.port.read()? {
            self.statistics.push(&truth);
        }
        if self.statistics.started.elapsed() < interval {
            return Ok(None);
        }
        let Interval { latest, received, .. } = self.statistics;
        Ok(Some(std::mem::replace(&mut self.statistics, Interval { latest, received, ..Interval::new() })))
    }
}

/// Statistics of the records between two updates.
pub(super) struct Interval {
    started: Instant,
    pub received: Instant,
    latest: Option<Truth>,
    first: Option<Truth>,
    count: u64,
    greatest_age: u32,
    reply: DurationStats,
    late: DurationStats,
    busy: DurationStats,
}

impl Interval {
    fn new() -> Interval {
        let now = Instant::now();
        Interval {
            started: now,
            received: now,
            latest: None,
            first: None,
            count: 0,
            greatest_age: 0,
            reply: DurationStats::default(),
            late: DurationStats::default(),
            busy: DurationStats::default(),
        }
    }

    fn push(&mut self, truth: &Truth) {
        self.first.get_or_insert(*truth);
        self.latest = Some(*truth);
        self.received = Instant::now();
        self.count += 1;
        self.greatest_age = self.greatest_age.max(truth.age);
        self.reply.add(truth.reply_ns);
        self.late.add(truth.late_ns);
        self.busy.add(truth.plant_ns);
    }

    /// Control periods per second, simulated time per wall-clock time, and speed [m/s].
    fn rates(&self) -> [f64; 3] {
        let (Some(first), Some(last)) = (self.first, self.latest) else { return [0.0, 0.0, f64::NAN] };
        let wall = self.started.elapsed().as_secs_f64();
        let simulated = last.stamp.sim_ns.saturating_sub(first.stamp.sim_ns) as f64 * 1e-9;
        let speed = (last.base_position[0] - first.base_position[0]) / simulated;
        [self.count as f64 / wall, simulated / wall, speed]
    }

    /// The statistics as lines for a terminal.
    pub fn lines(&self, session: &Session) -> Vec<String> {
        let Some(truth) = &self.latest else {
            return vec![format!("session {}: no records yet; a paused session sends none", session.name())];
        };
        let [rate, pace, speed] = self.rates();
        let (telemetry, tally) = (&truth.telemetry, &truth.tally);
        let state = name(&STATES, truth.state);
        let colour = match state.as_str() {
            "run" | "wait" => Style::new().green(),
            "paused" => Style::new().cyan(),
            "hold" | "damp" => Style::new().yellow(),
            _ => Style::new().red().bold(),
        };
        let key = Style::new().dim();
        let line = |name: &str, value: String| format!("{} {value}", key.apply_to(format!("{name:<11}")));
        let times = |times: &DurationStats| format!("mean {:.0} µs, greatest {:.0} µs", times.mean(), times.greatest());
        let refused: Vec<String> = (REFUSALS.iter().zip(tally.refused))
            .filter(|(_, count)| *count > 0)
            .map(|(why, count)| format!("{count} {why}"))
            .collect();
        let refused = if refused.is_empty() { "none".into() } else { refused.join(", ") };
        let time = truth.stamp.time();
        vec![
            line("session", format!("{}, run {:016x}, t {time:.2} s", session.name(), truth.stamp.run)),
            line("pace", format!("{rate:.0} periods/s, {pace:.2} x real time")),
            line("drives", format!("{}", colour.apply_to(state))),
            line("gait", format!("{}, step {}, {speed:+.3} m/s", support(truth), telemetry.steps)),
            line("energies", energies(truth)),
            line("age", format!("{} periods, greatest {}", truth.age, self.greatest_age)),
            line("reply", times(&self.reply)),
            line("late", times(&self.late)),
            line("plant", times(&self.busy)),
            line(
                "residuals",
                format!("natural map {}, Signorini {}", scientific(truth.natural_map), scientific(truth.signorini)),
            ),
            line("refused", refused),
            line(
                "periods",
                format!(
                    "{} held, {} damped, {} with drives off, {} skipped",
                    tally.held, tally.damped, tally.faulted, tally.skipped
                ),
            ),
            line(
                "commands",
                format!("{} lost, {} takeovers, {} requests", tally.lost, tally.takeovers, tally.requests),
            ),
            line("steps", format!("{} fallbacks, {} periods not recorded", truth.fallbacks, tally.unrecorded)),
        ]
    }

    /// The statistics as one line without colours.
    pub fn line(&self) -> String {
        let Some(truth) = &self.latest else { return "no records yet; a paused session sends none".into() };
        let [rate, pace, speed] = self.rates();
        let time = truth.stamp.time();
        let refused: u64 = truth.tally.refused.iter().sum();
        format!(
            "t {time:.2} s  {rate:.0} Hz  {pace:.2}x  {}  {}  {speed:+.3} m/s  {}  age {}  reply {:.0} µs  late {:.0} µs  \
             refused {refused}  lost {}  skipped {}",
            name(&STATES, truth.state),
            support(truth),
            energies(truth),
            self.greatest_age,
            self.reply.mean(),
            self.late.greatest(),
            truth.tally.lost,
            truth.tally.skipped,
        )
    }
}

/// Mean and maximum of durations.
#[derive(Default)]
struct DurationStats {
    sum: u64,
    count: u64,
    greatest: u64,
}

impl DurationStats {
    fn add(&mut self, ns: u64) {
        (self.sum, self.count, self.greatest) = (self.sum + ns, self.count + 1, self.greatest.max(ns));
    }

    /// Mean [µs].
    fn mean(&self) -> f64 {
        self.sum as f64 * 1e-3 / self.count.max(1) as f64
    }

    /// Maximum [µs].
    fn greatest(&self) -> f64 {
        self.greatest as f64 * 1e-3
    }
}

fn name(names: &[&str], index: u32) -> String {
    names.get(index as usize).copied().unwrap_or("?").into()
}

fn support(truth: &Truth) -> String {
    let foot = if truth.telemetry.support == 0 { "left" } else { "right" };
    format!("{}, {foot} foot", name(&PHASES, truth.telemetry.phase))
}

fn energies(truth: &Truth) -> String {
    let ([e1, e2], [ref1, ref2]) = (truth.telemetry.energy, truth.telemetry.energy_ref);
    format!("E1 {e1:+.4} of {ref1:+.4}, E2 {e2:+.4} of {ref2:+.4}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::synthetic::SyntheticWalk;

    #[test]
    fn all_lines_of_an_ordinary_walk_fit_a_narrow_terminal() {
        let mut statistics = Interval::new();
        for period in 0..2000 {
            statistics.push(&SyntheticWalk::new(0.06).truth(period, 9.0 + period as f64 * 1e-3));
        }
        for line in statistics.lines(&Session::named("laboratory").expect("a good name")) {
            assert!(console::measure_text_width(&line) <= 60, "{line}");
        }
    }
}
