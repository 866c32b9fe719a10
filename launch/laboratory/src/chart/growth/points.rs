//! Measurements of a curve, and its exponent.

use super::scenes::GrowthCurve;

/// One measurement.
pub struct Point {
    /// Name of the curve.
    pub curve: &'static str,
    /// Simulator.
    pub engine: &'static str,
    /// Value of the growing quantity, for example the number of contacts.
    pub x: f64,
    /// Time of a step [µs].
    pub us: f64,
}

/// Adds a measurement; of several at the same place the least counts.
pub fn keep_least(points: &mut Vec<Point>, new: Point) {
    let same = |old: &&mut Point| (old.curve, old.engine, old.x) == (new.curve, new.engine, new.x);
    match points.iter_mut().find(same) {
        Some(old) => old.us = old.us.min(new.us),
        None => points.push(new),
    }
}

/// Points of one engine on a curve.
pub fn of<'a>(points: &'a [Point], curve: &GrowthCurve, engine: &str) -> Vec<&'a Point> {
    points.iter().filter(|point| point.curve == curve.name && point.engine == engine).collect()
}

/// The exponent p of us ~ xᵖ to two digits, by a least-squares fit of logarithms for x >= `from`; `None` for fewer than two points.
pub fn exponent(points: &[&Point], from: f64) -> Option<f64> {
    let logs = points.iter().filter(|point| point.x >= from).map(|point| (point.x.ln(), point.us.ln()));
    let logs: Vec<_> = logs.collect();
    let n = logs.len() as f64;
    let mean = logs.iter().fold((0.0, 0.0), |(x, y), log| (x + log.0 / n, y + log.1 / n));
    let (above, below) = logs.iter().fold((0.0, 0.0), |(above, below), (x, y)| {
        (above + (x - mean.0) * (y - mean.1), below + (x - mean.0) * (x - mean.0))
    });
    (logs.len() > 1).then(|| (100.0 * above / below).round() / 100.0 + 0.0) // two digits, and no -0
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::chart::csv::OURS;

    #[test]
    fn a_power_law_has_its_exponent() {
        let points =
            [1.0, 2.0, 4.0, 8.0].map(|x: f64| Point { curve: "links", engine: OURS, x, us: 3.0 * x.powf(1.5) });
        let fitted = exponent(&points.iter().collect::<Vec<_>>(), 2.0).expect("three points");
        assert_eq!(fitted, 1.5);
        assert!(exponent(&[&points[0]], 0.0).is_none());
    }
}
