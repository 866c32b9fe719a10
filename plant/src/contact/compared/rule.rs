//! The laws of round cones, cylinders and pyramids as one equation, f = P_K(f - v^): how far an impulse is from it.

use super::super::certificate::relative;
use super::super::project::cone;
use super::super::round::{Round, part};
use super::polygon::{bounded, greatest_slip, pyramid};

/// What the impulse of a contact has to obey: f = P_K(f - v^) with a cone K and a corrected velocity v^.
#[derive(Clone, Copy, Debug)]
pub(super) enum Rule<'a> {
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
pub(super) fn natural_map(round: &Round, rule: Rule<'_>, f: &[f64], v: &[f64]) -> f64 {
    let mut worst = 0.0_f64;
    for i in 0..round.contacts {
        let (f, v, mu) = (part(f, i), part(v, i), round.friction[i]);
        let shift = match rule {
            Rule::Coulomb => mu * v[1].hypot(v[2]),
            Rule::Energy(shift) => shift.get(i).copied().unwrap_or(0.0),
            Rule::Bound(_) => 0.0,
            Rule::Polygon(d) => mu * greatest_slip(d, v),
        };
        let x = [f[0] - v[0] - shift, f[1] - v[1], f[2] - v[2]];
        let nearest = match rule {
            Rule::Coulomb | Rule::Energy(_) => cone(x, mu),
            Rule::Bound(bound) => bounded(x, bound[i]),
            Rule::Polygon(d) => pyramid(x, mu, d),
        };
        for k in 0..3 {
            // Neither the projection nor f64::max may hide a NaN.
            let error = (f[k] - nearest[k]).abs() + 0.0 * x[k];
            worst = if worst.is_nan() || error <= worst { worst } else { error };
        }
    }
    relative(worst, round.reach(f))
}

/// Step rho of a tangent impulse against a slip, the inverse of the greater tangent diagonal.
pub(super) fn tangent_step(round: &Round, i: usize) -> f64 {
    let n = 3 * round.contacts;
    let diagonal = |k: usize| round.delassus[k * n + k];
    let greater = diagonal(3 * i + 1).max(diagonal(3 * i + 2));
    if greater > 0.0 { 1.0 / greater } else { 1.0 }
}
