//! Projections on the friction sets other than the round cone: cylinder and pyramid. Coordinates are (normal, two tangents).

use super::super::projection::norm;

/// Nearest point of f_N >= 0, |f_F| <= bound.
pub(super) fn project_on_cylinder(x: [f64; 3], bound: f64) -> [f64; 3] {
    let r = norm(x[1], x[2]);
    let share = if r > bound { bound / r } else { 1.0 };
    [x[0].max(0.0), share * x[1], share * x[2]]
}

/// Vertex j of the friction polygon.
pub(super) fn vertex(d: usize, j: usize) -> [f64; 2] {
    // Exact along the axes.
    match 4 * j % (4 * d) / d {
        0 if j.is_multiple_of(d) => [1.0, 0.0],
        1 if (4 * j).is_multiple_of(d) => [0.0, 1.0],
        2 if (4 * j).is_multiple_of(d) => [-1.0, 0.0],
        3 if (4 * j).is_multiple_of(d) => [0.0, -1.0],
        _ => {
            let (sin, cos) = libm::sincos(std::f64::consts::TAU * j as f64 / d as f64);
            [cos, sin]
        }
    }
}

/// Greatest slip speed against a vertex of the polygon.
pub(super) fn greatest_slip(d: usize, v: [f64; 3]) -> f64 {
    (0..d).map(|j| vertex(d, j)).map(|[c, s]| -(c * v[1] + s * v[2])).fold(0.0, f64::max)
}

/// Nearest point of the pyramid whose edges are (1, μ vertex).
pub(super) fn project_on_pyramid(x: [f64; 3], mu: f64, d: usize) -> [f64; 3] {
    // In the sector of one side: x = (n, across, along), with 0 at the middle of the side.
    let sector = std::f64::consts::TAU / d as f64;
    let middle = ((libm::atan2(x[2], x[1]) / sector).floor() + 0.5) * sector;
    let (sin, cos) = libm::sincos(middle);
    let (across, along) = (cos * x[1] + sin * x[2], cos * x[2] - sin * x[1]);
    let (depth, half) = (libm::cos(sector / 2.0) * mu, libm::sin(sector / 2.0) * mu);
    if across <= depth * x[0] {
        return x;
    }
    // The face is across = depth n. Beyond its edges, the nearest point lies on the nearer edge, along = ±half n.
    let edge = ((x[0] + depth * across) / (1.0 + depth * depth)).max(0.0);
    let nearest = if along.abs() <= half * edge {
        [edge, depth * edge, along]
    } else {
        let edge = (x[0] + depth * across + half * along.abs()) / (1.0 + mu * mu);
        let edge = edge.max(0.0);
        [edge, depth * edge, (half * edge).copysign(along)]
    };
    [nearest[0], cos * nearest[1] - sin * nearest[2], sin * nearest[1] + cos * nearest[2]]
}
