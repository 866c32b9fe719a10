//! A histogram with logarithmic bins.

/// Counts values by their decimal logarithm.
#[derive(Clone, Debug)]
pub struct Histogram {
    /// Decimal logarithm of the lower edge of the first bin.
    lowest: i32,
    counts: Vec<u64>,
    /// Number of values without a logarithm: zero, negative or NaN.
    pub zeros: u64,
}

impl Histogram {
    /// Bins per decade: a bin is 4 % wide, and the figures merge whole bins into bars (60 is divisible by 4 and 15).
    const PER_DECADE: usize = 60;

    /// Bins from 10^`lowest` to 10^`highest`. A value outside counts in the nearest bin.
    pub fn new([lowest, highest]: [i32; 2]) -> Self {
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

    /// Number of values.
    pub fn total(&self) -> u64 {
        self.zeros + self.counts.iter().sum::<u64>()
    }

    /// The `q` quantile, rounded up to the edge of its bin. 0 if that quantile has no logarithm.
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

    /// Non-empty bars of `1/per_decade` decades: logarithm of the lower edge, and count.
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
    fn quantiles_are_exact_to_the_width_of_a_bin() {
        let mut histogram = Histogram::new([0, 6]);
        (1..=1000).for_each(|i| histogram.add(f64::from(i)));
        for (q, exact) in [(0.5, 500.0), (0.99, 990.0), (1.0, 1000.0)] {
            assert!((histogram.quantile(q) / exact).ln().abs() < 0.04, "{}", histogram.quantile(q));
        }
        histogram.add(f64::NAN);
        histogram.add(0.0);
        assert_eq!((histogram.zeros, histogram.total()), (2, 1002));
        assert_eq!(histogram.bars(4).iter().map(|bar| bar.1).sum::<u64>(), 1000);
    }
}
