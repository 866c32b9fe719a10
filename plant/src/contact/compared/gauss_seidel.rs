//! Projected Gauss-Seidel: each contact in turn gets the impulse that satisfies its condition, while the other impulses stay constant.
//!
//! If a mass rests on another one that is r times as light, a sweep leaves r/(1 + r) of the error: a digit takes 2.3 r sweeps. So the method
//! serves as a start for [`super::semismooth_newton`], and as a law of its own, the baseline of the comparison.

use super::super::projection::project_on_cone;
use super::super::round_cones::{RoundCones, contact_rows};
use super::condition::{Condition, tangent_step};
use super::polygon::project_on_cylinder;
use super::vector::dot;

/// Length of a projected gradient step, relative to the inverse diagonal of A [-]. With one half, the sweep stays stable where normal and
/// tangents are coupled.
const GRADIENT_STEP: f64 = 0.5;

/// One sweep over `f`.
pub(super) fn sweep(cones: &RoundCones, condition: Condition<'_>, f: &mut [f64]) {
    let n = f.len();
    for i in 0..cones.contacts {
        let at = |k: usize, f: &[f64]| dot(&cones.delassus[(3 * i + k) * n..][..n], f) + cones.drift[3 * i + k];
        let (mu, rho) = (cones.friction[i], tangent_step(cones, i));
        if let Condition::Energy(shift) = condition {
            let step = rho.min(1.0) * GRADIENT_STEP;
            let extra = shift.get(i).copied().unwrap_or(0.0);
            let old = contact_rows(f, i);
            let x = [0, 1, 2].map(|k| old[k] - step * (at(k, f) + if k == 0 { extra } else { 0.0 }));
            f[3 * i..3 * i + 3].copy_from_slice(&project_on_cone(x, mu));
            continue;
        }
        // A_NN is 1, or 0 without motion.
        f[3 * i] = (f[3 * i] - at(0, f)).max(0.0);
        let bound = match condition {
            Condition::Bound(bound) => bound[i],
            _ => mu * f[3 * i],
        };
        let x = [0.0, f[3 * i + 1] - rho * at(1, f), f[3 * i + 2] - rho * at(2, f)];
        let [_, a, b] = project_on_cylinder(x, bound);
        (f[3 * i + 1], f[3 * i + 2]) = (a, b);
    }
}
