//! Contact conditions with round cones, cylinders and pyramids, all in the form f = P_K(f - v̂), and their residual.

use super::super::certificate::relative;
use super::super::projection::project_on_cone;
use super::super::round_cones::{RoundCones, contact_rows};
use super::polygon::{greatest_slip, project_on_cylinder, project_on_pyramid};

/// The condition on the impulse of a contact: f = P_K(f - v̂) with a cone K and a shifted velocity v̂.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition<'a> {
    /// Coulomb's law, (17)-(22): v̂_N = v_N + μ |v_F|, K is the round cone (De Saxcé & Feng 1998).
    Coulomb,
    /// The minimum of (14) over the round cone: v̂_N = v_N plus the given shift of each contact; no shift if empty.
    Energy(&'a [f64]),
    /// Tresca friction: f_N >= 0, |f_F| at most the given bound of each contact, v̂ = v.
    Bound(&'a [f64]),
    /// Coulomb's law with friction in a polygon with this many vertices (cos, sin)(2 pi j/d): v̂_N = v_N + μ times the greatest slip
    /// against a vertex (Stewart & Trinkle 1996).
    Polygon(usize),
}

/// Natural map: the greatest entry of ||f - P_K(f - v̂)||, relative to the step's scale max(||f||, ||b||).
pub(super) fn natural_map(cones: &RoundCones, condition: Condition<'_>, f: &[f64], v: &[f64]) -> f64 {
    let mut greatest = 0.0_f64;
    for i in 0..cones.contacts {
        let (f, v, mu) = (contact_rows(f, i), contact_rows(v, i), cones.friction[i]);
        let shift = match condition {
            Condition::Coulomb => mu * libm::hypot(v[1], v[2]),
            Condition::Energy(shift) => shift.get(i).copied().unwrap_or(0.0),
            Condition::Bound(_) => 0.0,
            Condition::Polygon(d) => mu * greatest_slip(d, v),
        };
        let x = [f[0] - v[0] - shift, f[1] - v[1], f[2] - v[2]];
        let nearest = match condition {
            Condition::Coulomb | Condition::Energy(_) => project_on_cone(x, mu),
            Condition::Bound(bound) => project_on_cylinder(x, bound[i]),
            Condition::Polygon(d) => project_on_pyramid(x, mu, d),
        };
        for k in 0..3 {
            // Neither the projection nor f64::max may hide NaN.
            let error = (f[k] - nearest[k]).abs() + 0.0 * x[k];
            greatest = if greatest.is_nan() || error <= greatest { greatest } else { error };
        }
    }
    relative(greatest, cones.magnitude(f))
}

/// Step length rho of a tangential impulse against a slip: the inverse of the greater tangential diagonal entry.
pub(super) fn tangent_step(cones: &RoundCones, i: usize) -> f64 {
    let n = 3 * cones.contacts;
    let diagonal = |k: usize| cones.delassus[k * n + k];
    let greater = diagonal(3 * i + 1).max(diagonal(3 * i + 2));
    if greater > 0.0 { 1.0 / greater } else { 1.0 }
}
