//! The flat sole that a foot of a biped needs.

use super::Body;

/// Difference of heights, over the greatest coordinate, at which a sole is still flat, and its width over its length at which it is still a
/// line [-].
const ROUNDING: f64 = 1e-8;

/// Checks that a foot has a flat sole.
///
/// # Errors
/// What the foot needs.
pub(super) fn require_flat_sole(foot: &Body) -> Result<(), String> {
    let flat = foot.contacts.len() >= 3 && is_level(&foot.contacts) && !is_on_one_line(&foot.contacts);
    let what = "needs the corners of a flat sole: at least three contact points at the same height, not on one line";
    let balls = match foot.spheres.len() {
        0 => String::new(),
        balls => format!(
            "; its {balls} balls are no corners, since they roll: a sphere of a URDF file is a corner if its radius is exactly 0.001 m"
        ),
    };
    if flat { Ok(()) } else { Err(format!("`{}` {what}{balls}", foot.name)) }
}

/// Whether points are at one height, but for rounding of their coordinates.
fn is_level(points: &[[f64; 3]]) -> bool {
    let heights = || points.iter().map(|point| point[2]);
    let spread = heights().fold(f64::MIN, f64::max) - heights().fold(f64::MAX, f64::min);
    let farthest = points.iter().flatten().fold(0.0, |most: f64, part| most.max(part.abs()));
    spread <= ROUNDING * farthest
}

/// Whether points are on one line as seen from above: no triangle of the first point, the one farthest from it and another one has an area.
fn is_on_one_line(points: &[[f64; 3]]) -> bool {
    let arms = || points.iter().map(|point| [point[0] - points[0][0], point[1] - points[0][1]]);
    let square = |[x, y]: [f64; 2]| x * x + y * y;
    let far = arms().max_by(|a, b| square(*a).total_cmp(&square(*b))).unwrap_or_default();
    arms().all(|arm| (far[0] * arm[1] - far[1] * arm[0]).abs() <= ROUNDING * square(far))
}
