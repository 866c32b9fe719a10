//! Projection on the round cone. Coordinates are (normal, two tangents).

/// √(a² + b²), with the same bits on every machine.
#[inline(always)]
pub(super) fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Nearest point of the cone |x_F| <= μ x_N.
pub(super) fn project_on_cone(x: [f64; 3], mu: f64) -> [f64; 3] {
    let r = norm(x[1], x[2]);
    if r <= mu * x[0] {
        return x;
    }
    let edge = ((x[0] + mu * r) / (1.0 + mu * mu)).max(0.0);
    let along = if r > 0.0 { mu * edge / r } else { 0.0 };
    [edge, along * x[1], along * x[2]]
}
