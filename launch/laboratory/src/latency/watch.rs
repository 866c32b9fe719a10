//! Statistics of a real-time run, from the messages that a recorder receives.

use super::floor::PERIOD_NS;
use super::results::Results;
use super::spread::Spread;
use messages::wire::Truth;
use shared::exit::Failure;

/// Control periods in the window of the success rate.
const WINDOW: u64 = 100;

/// Counts over every control period.
pub struct HostWatch {
    wake: Spread,
    answer: Spread,
    compute: Spread,
    age: Spread,
    latest: Truth,
    misses: Misses,
}

/// Control periods without a new command in time.
#[derive(Clone, Copy, Debug, Default)]
struct Misses {
    all: u64,
    /// Control periods since the last answer, and the greatest number of them.
    now: u64,
    longest: u64,
    /// Answers among the last periods, one bit each.
    recent: u128,
    /// The least number of answers in a full window.
    fewest: Option<u32>,
    periods: u64,
}

impl Misses {
    fn take(&mut self, missed: bool) {
        self.periods += 1;
        self.all += u64::from(missed);
        self.now = if missed { self.now + 1 } else { 0 };
        self.longest = self.longest.max(self.now);
        self.recent = (self.recent << 1 | u128::from(!missed)) & ((1 << WINDOW) - 1);
        if self.periods >= WINDOW {
            let answers = self.recent.count_ones();
            self.fewest = Some(self.fewest.map_or(answers, |fewest| fewest.min(answers)));
        }
    }
}

impl HostWatch {
    /// Empty statistics.
    ///
    /// # Errors
    /// None; see [`Spread::new`].
    pub fn new() -> Result<HostWatch, Failure> {
        Ok(HostWatch {
            wake: Spread::new()?,
            answer: Spread::new()?,
            compute: Spread::new()?,
            age: Spread::new()?,
            latest: Truth::default(),
            misses: Misses::default(),
        })
    }

    /// Adds the truth of a control period. The first two precede the pacing by the clock.
    pub fn take(&mut self, truth: &Truth) {
        self.latest = *truth;
        if truth.stamp.seq <= 2 {
            return;
        }
        self.wake.add_due(truth.late_ns, PERIOD_NS);
        self.compute.add(truth.plant_ns);
        self.age.add(u64::from(truth.age) * PERIOD_NS);
        self.misses.take(truth.age > 0);
        if truth.reply_ns > 0 {
            self.answer.add(truth.reply_ns);
        }
    }

    /// Control periods so far.
    pub fn periods(&self) -> u64 {
        self.latest.stamp.seq
    }

    /// Start of the latest control period.
    pub fn begin_ns(&self) -> u64 {
        self.latest.stamp.mono_ns
    }

    /// Adds the statistics to the results.
    pub fn report(&self, results: &mut Results, section: &'static str) {
        results.put(section, "wake", &self.wake);
        results.put(section, "sensors to command", &self.answer);
        results.put(section, "plant computes", &self.compute);
        results.put(section, "age of the command", &self.age);
        let misses = self.misses;
        let answers = misses.fewest.unwrap_or(misses.recent.count_ones());
        let rate = f64::from(answers) / misses.periods.clamp(1, WINDOW) as f64;
        results.count(section, "control periods", misses.periods as f64);
        results.count(section, "periods skipped", self.latest.tally.skipped as f64);
        results.count(section, "answers missed", misses.all as f64);
        results.count(section, "longest miss [periods]", misses.longest as f64);
        results.count(section, "least success rate over 100", rate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misses_are_counted_alone_in_a_row_and_over_a_hundred() {
        let mut misses = Misses::default();
        (0..99).for_each(|_| misses.take(false));
        assert_eq!(misses.fewest, None);
        (0..3).for_each(|_| misses.take(true));
        (0..200).for_each(|_| misses.take(false));
        misses.take(true);
        assert_eq!((misses.all, misses.longest, misses.fewest, misses.periods), (4, 3, Some(97), 303));
    }
}
