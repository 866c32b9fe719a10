//! Checks of the numbers of a scene.

use crate::error::PlantError;
use nalgebra::Vector3;

/// A vector whose numbers are finite.
pub(crate) fn finite(value: [f64; 3], what: impl Fn() -> String) -> Result<Vector3<f64>, PlantError> {
    let good = value.iter().all(|component| component.is_finite());
    if good { Ok(value.into()) } else { Err(PlantError::value(what(), value, "finite")) }
}

/// A number that is finite and not negative.
pub(super) fn not_negative(value: f64, what: &str) -> Result<f64, PlantError> {
    let good = value >= 0.0 && value.is_finite();
    if good { Ok(value) } else { Err(PlantError::value(what, value, "finite and not negative")) }
}
