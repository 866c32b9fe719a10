//! Scales of length and time of a model, to which the constants of contact are relative.

use super::settings::World;

/// [`natural_rate`] without gravity [1/dt]: about that of the comparison scenes at 1 ms.
const RATE_WITHOUT_GRAVITY: f64 = 0.01;

/// The greatest of some numbers, whatever their sign.
pub(super) fn greatest_size(numbers: impl IntoIterator<Item = f64>) -> f64 {
    numbers.into_iter().map(f64::abs).fold(0.0, f64::max)
}

/// The length of the model, rounded down to a power of two [m]. The smallest model of a scene is nearly as long as the full one, and has to
/// move alike.
pub(super) fn typical_length(world: &World) -> f64 {
    libm::ldexp(1.0, libm::ilogb(world.model.length))
}

/// Rate of a pendulum as long as the model, √(g/l): the scale of the motion that gravity causes [1/s].
pub(super) fn natural_rate(world: &World) -> f64 {
    let World { model, settings, .. } = world;
    let rate = (model.gravity.norm() / typical_length(world)).sqrt();
    if rate > 0.0 && rate.is_finite() { rate } else { RATE_WITHOUT_GRAVITY / settings.h }
}
