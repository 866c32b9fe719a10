//! Vector operations of the compared laws, written for vector registers.

/// Greatest magnitude of some numbers; ignores NaN.
pub(super) fn max_abs(numbers: &[f64]) -> f64 {
    let greater = |most: f64, x: f64| if x.abs() > most { x.abs() } else { most };
    let (fours, rest) = numbers.as_chunks::<4>();
    let most = fours.iter().fold([0.0; 4], |most, four| std::array::from_fn(|k| greater(most[k], four[k])));
    rest.iter().chain(&most).fold(0.0, |most, x| greater(most, *x))
}

/// Scalar product with four partial sums, which fit in vector registers.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sum = [0.0; 4];
    let (ca, cb) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = ca.remainder().iter().zip(cb.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in ca.zip(cb) {
        for k in 0..4 {
            sum[k] += x[k] * y[k];
        }
    }
    (sum[0] + sum[1]) + (sum[2] + sum[3]) + rest
}
