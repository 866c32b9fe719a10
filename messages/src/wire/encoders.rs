//! Encoder counts as angles.

use super::declaration::{Encoders, JOINTS};

impl Encoders {
    /// Angle of each joint [rad]. The scene has the angle of a count: `scene.plant.radians_per_count()`.
    pub fn angles(&self, radians_per_count: f64) -> [f64; JOINTS] {
        self.counts.map(|count| radians_per_count * count as f64)
    }
}
