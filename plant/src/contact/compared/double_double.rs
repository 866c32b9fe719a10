//! Double-double arithmetic: a number with 32 digits as the sum of two with 16. Used by [`super::lemke`].
//!
//! # Source
//! Dekker, *A floating-point technique for extending the available precision*, 1971; Knuth's sum of two numbers.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`, where `low` is the rounding error of `high`. The derived order, by `high` and then `low`, is therefore that of the sums.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct DoubleDouble {
    high: f64,
    low: f64,
}

impl DoubleDouble {
    /// The exact sum of a larger and a smaller number.
    fn of(large: f64, small: f64) -> DoubleDouble {
        let high = large + small;
        DoubleDouble { high, low: small - (high - large) }
    }

    /// The exact sum of any two numbers.
    fn sum(a: f64, b: f64) -> DoubleDouble {
        let high = a + b;
        let part = high - a;
        DoubleDouble { high, low: (a - (high - part)) + (b - part) }
    }

    /// The exact product of two numbers.
    fn product(a: f64, b: f64) -> DoubleDouble {
        let high = a * b;
        let ((a, c), (b, d)) = (halves(a), halves(b));
        DoubleDouble { high, low: ((a * b - high) + a * d + c * b) + c * d }
    }
}

/// 2²⁷ + 1: the factor that splits the 53 bits of a number into two halves (Dekker).
const SPLITTER: f64 = 134_217_729.0;

/// Splits a number into two with half of its digits each.
fn halves(x: f64) -> (f64, f64) {
    let shifted = x * SPLITTER;
    let high = shifted - (shifted - x);
    (high, x - high)
}

impl From<f64> for DoubleDouble {
    fn from(high: f64) -> DoubleDouble {
        DoubleDouble { high, low: 0.0 }
    }
}

impl From<DoubleDouble> for f64 {
    fn from(x: DoubleDouble) -> f64 {
        x.high
    }
}

impl Neg for DoubleDouble {
    type Output = DoubleDouble;
    fn neg(self) -> DoubleDouble {
        DoubleDouble { high: -self.high, low: -self.low }
    }
}

impl Add for DoubleDouble {
    type Output = DoubleDouble;
    fn add(self, other: DoubleDouble) -> DoubleDouble {
        let (high, low) = (DoubleDouble::sum(self.high, other.high), DoubleDouble::sum(self.low, other.low));
        let sum = DoubleDouble::of(high.high, high.low + low.high);
        DoubleDouble::of(sum.high, sum.low + low.low)
    }
}

impl Sub for DoubleDouble {
    type Output = DoubleDouble;
    fn sub(self, other: DoubleDouble) -> DoubleDouble {
        self + -other
    }
}

impl Mul for DoubleDouble {
    type Output = DoubleDouble;
    fn mul(self, other: DoubleDouble) -> DoubleDouble {
        let exact = DoubleDouble::product(self.high, other.high);
        DoubleDouble::of(exact.high, exact.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for DoubleDouble {
    type Output = DoubleDouble;
    fn div(self, other: DoubleDouble) -> DoubleDouble {
        let first = self.high / other.high;
        let rest = self - DoubleDouble::from(first) * other;
        let second = rest.high / other.high;
        let rest = rest - DoubleDouble::from(second) * other;
        DoubleDouble::of(first, second) + DoubleDouble::from(rest.high / other.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn double_double_keeps_thirty_digits() {
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..1000 {
            let [a, b, c] = [0; 3].map(|_| DoubleDouble::from(random.f64() - 0.5));
            let tiny = DoubleDouble::from(1e-20);
            let left: f64 = (((a / b + c) * b + tiny) - a - c * b - tiny).into();
            assert!(left.abs() <= 1e-30, "{a:?} {b:?} {c:?}: {left:e}");
            let lost = ((1.0 + 1e-20) - 1.0, f64::from(DoubleDouble::from(1.0) + tiny - DoubleDouble::from(1.0)));
            assert_eq!(lost, (0.0, 1e-20), "one number has sixteen");
        }
    }
}
