//! A number of 32 digits, as the sum of two of 16: for pivoting, see [`super::lemke`].
//!
//! # Source
//! Dekker, *A floating-point technique for extending the available precision*, 1971; Knuth's sum of two numbers.

use std::ops::{Add, Div, Mul, Neg, Sub};

/// `high + low`, of which `low` is what `high` has lost in rounding. Ordered as numbers are.
#[derive(Clone, Copy, Debug, Default, PartialEq, PartialOrd)]
pub(super) struct Twofold {
    high: f64,
    low: f64,
}

impl Twofold {
    /// The sum of a larger and a smaller number.
    fn of(large: f64, small: f64) -> Twofold {
        let high = large + small;
        Twofold { high, low: small - (high - large) }
    }

    /// The sum of any two numbers, exactly.
    fn sum(a: f64, b: f64) -> Twofold {
        let high = a + b;
        let part = high - a;
        Twofold { high, low: (a - (high - part)) + (b - part) }
    }

    /// The product of two numbers, exactly.
    fn product(a: f64, b: f64) -> Twofold {
        let high = a * b;
        let ((a, c), (b, d)) = (halves(a), halves(b));
        Twofold { high, low: ((a * b - high) + a * d + c * b) + c * d }
    }
}

/// A number as the sum of two that have half its digits.
fn halves(x: f64) -> (f64, f64) {
    let shifted = x * 134_217_729.0; // 2^27 + 1
    let high = shifted - (shifted - x);
    (high, x - high)
}

impl From<f64> for Twofold {
    fn from(high: f64) -> Twofold {
        Twofold { high, low: 0.0 }
    }
}

impl From<Twofold> for f64 {
    fn from(x: Twofold) -> f64 {
        x.high
    }
}

impl Neg for Twofold {
    type Output = Twofold;
    fn neg(self) -> Twofold {
        Twofold { high: -self.high, low: -self.low }
    }
}

impl Add for Twofold {
    type Output = Twofold;
    fn add(self, other: Twofold) -> Twofold {
        let (high, low) = (Twofold::sum(self.high, other.high), Twofold::sum(self.low, other.low));
        let sum = Twofold::of(high.high, high.low + low.high);
        Twofold::of(sum.high, sum.low + low.low)
    }
}

impl Sub for Twofold {
    type Output = Twofold;
    fn sub(self, other: Twofold) -> Twofold {
        self + -other
    }
}

impl Mul for Twofold {
    type Output = Twofold;
    fn mul(self, other: Twofold) -> Twofold {
        let exact = Twofold::product(self.high, other.high);
        Twofold::of(exact.high, exact.low + (self.high * other.low + self.low * other.high))
    }
}

impl Div for Twofold {
    type Output = Twofold;
    fn div(self, other: Twofold) -> Twofold {
        let first = self.high / other.high;
        let rest = self - Twofold::from(first) * other;
        let second = rest.high / other.high;
        let rest = rest - Twofold::from(second) * other;
        Twofold::of(first, second) + Twofold::from(rest.high / other.high)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thirty_digits_survive_what_one_number_loses() {
        let mut random = fastrand::Rng::with_seed(7);
        for _ in 0..1000 {
            let [a, b, c] = [0; 3].map(|_| Twofold::from(random.f64() - 0.5));
            let tiny = Twofold::from(1e-20);
            let left: f64 = (((a / b + c) * b + tiny) - a - c * b - tiny).into();
            assert!(left.abs() <= 1e-30, "{a:?} {b:?} {c:?}: {left:e}");
            let lost = ((1.0 + 1e-20) - 1.0, f64::from(Twofold::from(1.0) + tiny - Twofold::from(1.0)));
            assert_eq!(lost, (0.0, 1e-20), "one number has sixteen");
        }
    }
}
