//! Projected Gauss-Seidel: one contact after the other gets the impulse that its own law asks for, the others held.
//!
//! With two masses on each other, the heavier r times the lighter, a sweep leaves r/(1 + r) of the error: 2.3 r sweeps per
//! digit. So it is a start for [`super::newton`], and a law of its own as a baseline.

use super::super::project::cone;
use super::super::round::{Round, part};
use super::polygon::bounded;
use super::rule::{Rule, tangent_step};
use super::scaled::dot;

/// One sweep over `f`.
pub(super) fn sweep(round: &Round, rule: Rule<'_>, f: &mut [f64]) {
    let n = f.len();
    for i in 0..round.contacts {
        let at = |k: usize, f: &[f64]| dot(&round.delassus[(3 * i + k) * n..][..n], f) + round.drift[3 * i + k];
        let (mu, rho) = (round.friction[i], tangent_step(round, i));
        if let Rule::Energy(shift) = rule {
            let step = rho.min(1.0) / 2.0;
            let extra = shift.get(i).copied().unwrap_or(0.0);
            let old = part(f, i);
            let x = [0, 1, 2].map(|k| old[k] - step * (at(k, f) + if k == 0 { extra } else { 0.0 }));
            f[3 * i..3 * i + 3].copy_from_slice(&cone(x, mu));
            continue;
        }
        // A_NN is 1, or 0 where nothing can move.
        f[3 * i] = (f[3 * i] - at(0, f)).max(0.0);
        let bound = match rule {
            Rule::Bound(bound) => bound[i],
            _ => mu * f[3 * i],
        };
        let x = [0.0, f[3 * i + 1] - rho * at(1, f), f[3 * i + 2] - rho * at(2, f)];
        let [_, a, b] = bounded(x, bound);
        (f[3 * i + 1], f[3 * i + 2]) = (a, b);
    }
}
