//! The results: distributions, counts and targets, as text and as JSON.

use super::host::Host;
use super::spread::{Numbers, Spread};
use serde::Serialize;
use shared::exit::{Exit, Failure};
use std::fmt;

/// All of it.
pub struct Results {
    pub series: Vec<Series>,
    pub counts: Vec<Count>,
    pub targets: Vec<LatencyTarget>,
    pub host: Host,
}

/// One quantity in one measurement.
pub struct Series {
    /// The measurement.
    pub section: &'static str,
    /// The quantity.
    pub metric: &'static str,
    pub spread: Spread,
}

/// A count or a share.
#[derive(Serialize)]
pub struct Count {
    pub section: &'static str,
    pub metric: &'static str,
    pub value: f64,
}

/// A ratio within this run, and its upper limit.
#[derive(Serialize)]
pub struct LatencyTarget {
    pub name: &'static str,
    pub ratio: f64,
    pub limit: f64,
    pub met: bool,
}

/// The written form of a series.
#[derive(Serialize)]
struct LatencyRow {
    section: &'static str,
    metric: &'static str,
    #[serde(flatten)]
    numbers: Numbers,
}

#[derive(Serialize)]
struct Page<'a> {
    valid: bool,
    remark: String,
    host: &'a Host,
    targets: &'a [LatencyTarget],
    series: Vec<LatencyRow>,
    counts: &'a [Count],
}

impl Results {
    /// Empty results; the load of the host is measured from now on.
    pub fn new(host: Host) -> Results {
        Results { series: vec![], counts: vec![], targets: vec![], host }
    }

    /// Adds samples to a series. The first samples create it.
    pub fn put(&mut self, section: &'static str, metric: &'static str, spread: &Spread) {
        match self.series.iter_mut().find(|series| (series.section, series.metric) == (section, metric)) {
            Some(series) => series.spread.merge(spread),
            None => self.series.push(Series { section, metric, spread: spread.clone() }),
        }
    }

    /// Adds a number.
    pub fn count(&mut self, section: &'static str, metric: &'static str, value: f64) {
        self.counts.push(Count { section, metric, value });
    }

    /// The series with these names.
    pub fn spread(&self, section: &str, metric: &str) -> Option<&Spread> {
        let mut found = self.series.iter().filter(|series| (series.section, series.metric) == (section, metric));
        found.next().map(|series| &series.spread)
    }

    /// Compares two series by a quantile.
    pub fn judge(&mut self, name: &'static str, [of, to]: [(&str, &str); 2], quantile: f64, limit: f64) {
        let at = |(section, metric)| self.spread(section, metric).map_or(f64::NAN, |s| s.quantile(quantile) as f64);
        let ratio = at(of) / at(to);
        self.targets.push(LatencyTarget { name, ratio, limit, met: ratio <= limit });
    }

    /// As JSON.
    ///
    /// # Errors
    /// Results that cannot be written as JSON.
    pub fn json(&self) -> Result<String, Failure> {
        let row = |series: &Series| LatencyRow {
            section: series.section,
            metric: series.metric,
            numbers: series.spread.numbers(),
        };
        let page = Page {
            valid: self.host.is_valid(),
            remark: self.host.remark(),
            host: &self.host,
            targets: &self.targets,
            series: self.series.iter().map(row).collect(),
            counts: &self.counts,
        };
        serde_json::to_string_pretty(&page).map_err(|error| Failure::new(Exit::Fault, error))
    }
}

/// A duration in microseconds with its significant digits.
pub fn micros(ns: u64) -> String {
    let us = ns as f64 * 1e-3;
    match us {
        _ if us < 10.0 => format!("{us:.2}"),
        _ if us < 1000.0 => format!("{us:.1}"),
        _ => format!("{us:.0}"),
    }
}

impl fmt::Display for LatencyTarget {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let verdict = if self.met { "met" } else { "not met" };
        write!(f, "{:>6.2} (target {:.1}): {verdict}", self.ratio, self.limit)
    }
}

impl fmt::Display for Results {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        writeln!(f, "{:<46}{:>9}{:>9}{:>9}{:>9}{:>9}", "[µs]", "median", "99 %", "99.9 %", "max", "samples")?;
        let mut section = "";
        for series in &self.series {
            if series.section != section {
                section = series.section;
                writeln!(f, "{section}")?;
            }
            let numbers = series.spread.numbers();
            let [median, p99, p99_9, max] =
                [numbers.median_ns, numbers.p99_ns, numbers.p99_9_ns, numbers.max_ns].map(micros);
            writeln!(f, "  {:<44}{median:>9}{p99:>9}{p99_9:>9}{max:>9}{:>9}", series.metric, numbers.samples)?;
        }
        section = "";
        for count in &self.counts {
            if count.section != section {
                section = count.section;
                writeln!(f, "{section}, counts")?;
            }
            writeln!(f, "  {:<44}{:>9}", count.metric, count.value)?;
        }
        writeln!(f, "targets, as ratios within this run")?;
        self.targets.iter().try_for_each(|target| writeln!(f, "  {:<48}{target}", target.name))?;
        writeln!(f, "{}", self.host)
    }
}
