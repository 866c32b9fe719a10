//! The laws of round cones, cylinders and pyramids as one equation, f = P_K(f - v^): how far an impulse is from it.

use super::super::certificate::relative;
use super::super::projection::project_on_cone;
use super::super::round_cones::{RoundCones, contact_rows};
use super::polygon::{greatest_slip, project_on_cylinder, project_on_pyramid};

/// What the impulse of a contact has to obey: f = P_K(f - v^) with a cone K and a corrected velocity v^.
#[derive(Clone, Copy, Debug)]
pub(super) enum Condition<'a> {
    /// Coulomb's law, (17)-(22): v^_N = v_N + mu |v_F|, K the round cone (De Saxcé & Feng 1998).
    Coulomb,
    /// The minimum of (14) over the round cone: v^_N = v_N plus a given shift (none if empty).
    Energy(&'a [f64]),
    /// f_N >= 0, |f_F| no more than given for each contact: v^ = v (Tresca).
    Bound(&'a [f64]),
    /// Coulomb's law with friction in the polygon of this many corners (cos, sin)(2 pi j/d), v^_N = v_N + mu times the
    /// greatest slip against one of them (Stewart & Trinkle 1996).
    Polygon(usize),
}

/// Natural map ||f - P_K(f - v^)||, the greatest entry, relative to the step's scale max(||f||, ||b||).
pub(super) fn natural_map(cones: &RoundCones, condition: Condition<'_>, f: &[f64], v: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..cones.contacts {
        let (f, v, mu) = (contact_rows(f, i), contact_rows(v, i), cones.friction[i]);
        let shift = match condition {
            Condition::Coulomb => mu * v[1].hypot(v[2]),
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
            // Neither the projection nor f64::max may hide a NaN.
            let error = (f[k] - nearest[k]).abs() + 0.0 * x[k];
            worst = if worst.is_nan() || error <= worst { worst } else { error };
        }
    }
    relative(worst, cones.magnitude(f))
}

/// Step rho of a tangent impulse against a slip, the inverse of the greater tangent diagonal.
pub(super) fn tangent_step(cones: &RoundCones, i: usize) -> f64 {
    let n = 3 * cones.contacts;
    let diagonal = |k: usize| cones.delassus[k * n + k];
    let greater = diagonal(3 * i + 1).max(diagonal(3 * i + 2));
    if greater > 0.0 { 1.0 / greater } else { 1.0 }
}
