//! The distribution of a duration over many samples.

use hdrhistogram::Histogram;
use serde::Serialize;
use shared::exit::{Exit, Failure};

/// Range and resolution of the histogram: 1 ns to 100 s, three digits.
const LONGEST: u64 = 100_000_000_000;
const DIGITS: u8 = 3;

/// A histogram of durations in nanoseconds.
#[derive(Clone, Debug)]
pub struct Spread(Histogram<u64>);

/// A distribution in a few numbers [ns].
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Numbers {
    /// Number of samples, including those that a stall has suppressed.
    pub samples: u64,
    pub min_ns: u64,
    pub mean_ns: f64,
    pub median_ns: u64,
    pub p99_ns: u64,
    pub p99_9_ns: u64,
    pub max_ns: u64,
}

impl Spread {
    /// An empty distribution.
    ///
    /// # Errors
    /// None with the constants above.
    pub fn new() -> Result<Spread, Failure> {
        let made = Histogram::new_with_bounds(1, LONGEST, DIGITS);
        made.map(Spread).map_err(|error| Failure::new(Exit::Fault, error))
    }

    /// Counts durations.
    ///
    /// # Errors
    /// None; see [`Spread::new`].
    pub fn of(times: impl IntoIterator<Item = u64>) -> Result<Spread, Failure> {
        let mut spread = Spread::new()?;
        times.into_iter().for_each(|ns| spread.add(ns));
        Ok(spread)
    }

    /// Counts a duration.
    pub fn add(&mut self, ns: u64) {
        self.0.saturating_record(ns);
    }

    /// Counts the delay of an event that is due every `interval` ns, together with the events that were due meanwhile. Otherwise a stall
    /// of ten intervals would count as one late sample instead of ten.
    pub fn add_due(&mut self, late: u64, interval: u64) {
        (0..=late / interval.max(1)).for_each(|missed| self.add(late - missed * interval));
    }

    /// Adds the counts of another distribution.
    pub fn merge(&mut self, other: &Spread) {
        // cannot fail, because both have the same bounds
        let _ = self.0.add(&other.0);
    }

    /// The quantile `q` [ns].
    pub fn quantile(&self, q: f64) -> u64 {
        self.0.value_at_quantile(q)
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.0.len()
    }

    /// The numbers of a table.
    pub fn numbers(&self) -> Numbers {
        Numbers {
            samples: self.samples(),
            min_ns: self.0.min(),
            mean_ns: self.0.mean(),
            median_ns: self.quantile(0.5),
            p99_ns: self.quantile(0.99),
            p99_9_ns: self.quantile(0.999),
            max_ns: self.0.max(),
        }
    }

    /// The non-empty bins, `per_decade` of them per power of ten: decimal logarithm of the lower edge in ns, and share of all samples.
    pub fn bins(&self, per_decade: f64) -> Vec<(f64, f64)> {
        let mut bins: Vec<(f64, f64)> = Vec::new();
        for value in self.0.iter_recorded() {
            let edge = ((value.value_iterated_to().max(1) as f64).log10() * per_decade).floor() / per_decade;
            let share = value.count_at_value() as f64 / self.samples() as f64;
            match bins.last_mut().filter(|last| last.0 == edge) {
                Some(last) => last.1 += share,
                None => bins.push((edge, share)),
            }
        }
        bins
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_stall_counts_for_everything_that_was_due_in_it() {
        let mut spread = Spread::new().unwrap();
        (0..990).for_each(|_| spread.add_due(10, 1_000_000));
        spread.add_due(10_000_010, 1_000_000); // ten more were due, 9, 8, 7 … ms before
        let numbers = spread.numbers();
        assert_eq!((numbers.samples, numbers.median_ns), (1_001, 10));
        assert!(numbers.p99_ns.abs_diff(0) <= 10, "{numbers:?}");
        assert!((9_990_000..=10_010_000).contains(&numbers.max_ns) && numbers.p99_9_ns > 8_900_000, "{numbers:?}");
    }

    #[test]
    fn bins_hold_every_sample_where_it_belongs() {
        let mut spread = Spread::new().unwrap();
        [1, 10, 10, 99, 1000].iter().for_each(|ns| spread.add(*ns));
        let bins = spread.bins(1.0);
        assert_eq!(bins.iter().map(|bin| bin.0).collect::<Vec<_>>(), [0.0, 1.0, 3.0]);
        assert!((bins.iter().map(|bin| bin.1).sum::<f64>() - 1.0).abs() < 1e-12 && (bins[1].1 - 0.6).abs() < 1e-12);
    }
}
