//! Certificate of standing feet: a bound on the natural map that does not need A.
//!
//! The impulses lie within their cones, and a projection on a cone does not increase distances. So the natural map of a contact, |f − P_K(f
//! − (F/V) v̂)|/F, is at most |v̂|/V. V is the greatest speed of a contact without impulse, as in the certificate of the full problem.

use super::foot::Foot;
use crate::contact::{Report, relative};
use crate::detect::Touch;

/// The residuals of a solution. `speed` is V.
pub(super) fn report(feet: &[Foot], touches: &[Touch], friction: f64, speed: f64) -> Report {
    let mut left = 0.0_f64;
    for foot in feet {
        for (v, touch) in foot.velocities(&foot.motion, touches) {
            let (rise, slip) = ((v.z + touch.approach).abs(), v.xy().norm());
            left = left.max(libm::hypot(rise + friction * slip, slip));
        }
    }
    let natural_map = relative(left, speed);
    let work = |foot: &Foot| -> f64 {
        let pairs = foot.motion.iter().zip(&foot.free).zip(&foot.wrench);
        pairs.map(|((t, free), w)| 0.5 * w.dot(&(t + free))).sum()
    };
    let (energy_gain, work) =
        feet.iter().map(work).fold((0.0, 0.0), |(gain, all), work| (gain + work, all + work.abs()));
    Report { natural_map, own: natural_map, signorini: natural_map, energy_gain, work, warm: true, ..Report::default() }
}

/// V: the greatest speed of a contact without impulse. Its normal part counts only if it closes more than the gap within the step.
pub(super) fn speed(feet: &[Foot], touches: &[Touch]) -> f64 {
    let mut speed = 0.0_f64;
    for foot in feet {
        for (v, touch) in foot.velocities(&foot.free, touches) {
            speed = speed.max(v.xy().norm_squared() + (v.z + touch.approach).min(0.0).powi(2));
        }
    }
    speed.sqrt()
}
