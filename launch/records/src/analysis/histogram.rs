//! A histogram with logarithmic bins: how often which order of magnitude.

/// Counts values by their decimal logarithm.
#[derive(Clone, Debug)]
pub struct Histogram {
    lowest: i32,
    counts: Vec<u64>,
    /// Values that have no logarithm: zero, negative or NaN.
    pub zeros: u64,
}

impl Histogram {
    const PER_DECADE: usize = 60;

    /// Bins from 10^`lowest` to 10^`highest`; what lies outside counts in the nearest bin.
    pub fn new(lowest: i32, highest: i32) -> Self {
        let decades = highest.saturating_sub(lowest).max(1).unsigned_abs() as usize;
        Histogram { lowest, counts: vec![0; decades * Self::PER_DECADE], zeros: 0 }
    }

    /// Counts a value.
    pub fn add(&mut self, value: f64) {
        if value > 0.0 {
            let bin = ((value.log10() - f64::from(self.lowest)) * Self::PER_DECADE as f64).max(0.0) as usize;
            let last = self.counts.len() - 1;
            self.counts[bin.min(last)] += 1;
        } else {
            self.zeros += 1;
        }
    }

    /// Number of values counted.
    pub fn total(&self) -> u64 {
        self.zeros + self.counts.iter().sum::<u64>()
    }

    /// Upper edge of the bin below which the share `q` of all values lies (4 % wide); 0 if that share is zeros.
    pub fn quantile(&self, q: f64) -> f64 {
        let wanted = (q * self.total() as f64).ceil() as u64;
        let mut seen = self.zeros;
        if seen >= wanted {
            return 0.0;
        }
        let bin = self.counts.iter().position(|count| {
            seen += count;
            seen >= wanted
        });
        10f64.powf(self.edge(bin.unwrap_or(self.counts.len()) + 1))
    }

    /// Bars `1/per_decade` wide that hold anything: logarithm of the lower edge, and count.
    pub fn bars(&self, per_decade: usize) -> Vec<(f64, u64)> {
        let width = Self::PER_DECADE / per_decade.clamp(1, Self::PER_DECADE);
        (self.counts.chunks(width).enumerate())
            .map(|(i, bins)| (self.edge(i * width), bins.iter().sum()))
            .filter(|bar| bar.1 > 0)
            .collect()
    }

    fn edge(&self, bin: usize) -> f64 {
        f64::from(self.lowest) + bin as f64 / Self::PER_DECADE as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quantiles_of_a_histogram_are_within_its_bins() {
        let mut histogram = Histogram::new(0, 6);
        (1..=1000).for_each(|i| histogram.add(f64::from(i)));
        for (share, exact) in [(0.5, 500.0), (0.99, 990.0), (1.0, 1000.0)] {
            assert!((histogram.quantile(share) / exact).ln().abs() < 0.04, "{}", histogram.quantile(share));
        }
        histogram.add(f64::NAN);
        histogram.add(0.0);
        assert_eq!((histogram.zeros, histogram.total()), (2, 1002));
        assert_eq!(histogram.bars(4).iter().map(|bar| bar.1).sum::<u64>(), 1000);
    }
}
