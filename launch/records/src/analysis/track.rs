//! The way of the centre of mass along x.

use super::derived::DerivedState;

/// The centre of mass along x at one time.
#[derive(Clone, Copy)]
pub struct TrackPoint {
    /// Simulated time [s].
    pub time: f64,
    /// Position [m].
    pub x: f64,
    /// Velocity [m/s].
    pub velocity: f64,
}

impl TrackPoint {
    /// The point of a record.
    pub fn new(derived: &DerivedState) -> TrackPoint {
        TrackPoint { time: derived.time, x: derived.com.x, velocity: derived.com_velocity.x }
    }

    /// Position at a time between this point and a later one: that of the cubic through both [m].
    fn interpolate(&self, next: &TrackPoint, time: f64) -> f64 {
        let length = next.time - self.time;
        let s = if length > 0.0 { (time - self.time) / length } else { 0.0 };
        let end = s * s * (3.0 - 2.0 * s);
        self.x + end * (next.x - self.x) + length * s * (1.0 - s) * ((1.0 - s) * self.velocity - s * next.velocity)
    }
}

/// Mean speed over the second half of a track that continues until `end` [m/s]. NaN if it takes no time.
pub fn speed_of_second_half(track: &[TrackPoint], end: &TrackPoint) -> f64 {
    let Some(first) = track.first() else { return f64::NAN };
    let middle = 0.5 * (first.time + end.time);
    let after = track.partition_point(|point| point.time <= middle);
    let from = track[after - 1].interpolate(track.get(after).unwrap_or(end), middle);
    (end.x - from) / (end.time - middle)
}
