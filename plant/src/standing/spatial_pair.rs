//! Velocities and wrenches of the feet, as pairs of vectors or padded rows.

use nalgebra::Vector3;

/// Feet at most. With more, contacts are solved one by one.
pub(super) const MAX_FEET: usize = 4;
/// Velocity (v at c, angular) or wrench (force, moment about c), in W.
pub(super) type SpatialPair = [Vector3<f64>; 2];
/// The same as a row, padded to whole vector registers.
pub(super) type PaddedRow = [f64; 8];

pub(super) fn padded([linear, angular]: &SpatialPair) -> PaddedRow {
    [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z, 0.0, 0.0]
}

pub(super) fn unpadded(six: &PaddedRow) -> SpatialPair {
    [Vector3::new(six[0], six[1], six[2]), Vector3::new(six[3], six[4], six[5])]
}

/// Velocity of a point at d from c.
pub(super) fn point_velocity([linear, angular]: &SpatialPair, d: &Vector3<f64>) -> Vector3<f64> {
    linear + angular.cross(d)
}
