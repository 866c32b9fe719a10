//! Certificate of a contact impulse: how far it is from Coulomb's law with the round cone.
//!
//! The natural map of a contact compares its impulse with the nearest point of its cone,
//!
//! ```text
//!   r = |f − P_K(f − (F/V) v̂)| / F,   v̂ = (v_N + μ|v_F|, v_F),   F = max(|f|, V/A)
//! ```
//!
//! V is the greatest speed without contact impulse of all contacts that are coupled with this one. A is the greatest entry of this
//! contact's own diagonal. The map is zero exactly when the impulse obeys (17)-(22) with the round cone. Both scales belong to the contact
//! itself, so a heavy neighbour hides no error: r bounds the error of the impulse relative to F, and the error of the velocity relative to
//! V. Near the tolerance it allows for the rounding of A f. But it is 1 if that halves it for a contact that has to leave the ground and misses
//! half of its speed, or may miss it: where friction jams it no impulse moves it, and the rounding of a huge one would hide that.
//!
//! # Source
//! De Saxcé & Feng (1998); Acary & Brogliato (2008), 12.

use super::law::approach_offset;
use super::problem::Problem;
use super::projection::{norm, project_on_cone};
use super::tolerance::{ABOVE_ROUNDING, EXCUSED, MISSED, NO_DIRECTION, ROUNDING, ROUNDING_OF_A, SOLVED};
use messages::scene::Law;
use std::ops::Range;

/// Residuals of Coulomb's law.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Residual {
    /// Greatest natural map of all contacts [-].
    pub natural_map: f64,
    /// Greatest violation of (19): |f_N v_N|, relative to F V [-]. For a contact that enters the ground with more than half of V it is −v_N/V.
    pub signorini: f64,
    /// Some contact does.
    pub enters: bool,
    /// Greatest angle between friction and −slip [rad].
    pub misalignment: f64,
}

/// Scales of one contact: V [m/s] and F [N·s].
#[derive(Clone, Copy, Debug)]
pub(super) struct Scales {
    pub speed: f64,
    pub impulse: f64,
    /// Rounding of the velocity [m/s]; zero if it was not computed.
    pub rounding: f64,
}

impl Scales {
    /// Scales for an impulse f at a contact of inverse mass A.
    pub fn of(speed: f64, inverse_mass: f64, f: [f64; 3]) -> Scales {
        let size = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]).sqrt();
        let stopping = if inverse_mass > 0.0 { speed / inverse_mass } else { 0.0 };
        Scales { speed, impulse: if size > stopping { size } else { stopping }, rounding: 0.0 }
    }

    /// The same scales, raised to the rounding of A f + b: with large terms Σ|A f| or b, rounding hides velocities of the size of V. A slip
    /// up to `least_slip`, relative to these terms, counts as none, however great the friction coefficient is.
    fn limited_by_rounding(self, sum: f64, least_slip: f64, inverse_mass: f64, f: [f64; 3]) -> Scales {
        let known = sum * (ROUNDING / SOLVED);
        let scales = if known > self.speed { Scales::of(known, inverse_mass, f) } else { self };
        Scales { rounding: least_slip * sum, ..scales }
    }

    /// The natural map of one contact. f and F may have any common unit, and so may v and V. Where the direction of slip is `given`,
    /// friction acts against that direction at every velocity.
    #[inline]
    pub fn natural_map(self, f: [f64; 3], v: [f64; 3], friction: f64, given: [f64; 2]) -> f64 {
        let nan = 0.0 * ((f[0] + f[1] + f[2]) + (v[0] + v[1] + v[2])); // NaN if any number is NaN, because the comparisons below would hide it
        if self.speed == 0.0 || self.impulse == 0.0 {
            let violates = v.iter().any(|v| *v != 0.0) && f.iter().any(|f| *f != 0.0) || v[0] < 0.0;
            return if violates { f64::INFINITY } else { 0.0 } + nan;
        }
        let step = self.impulse / self.speed;
        let nearest = if given == [0.0; 2] {
            let slip = (norm(v[1], v[2]) - self.rounding).max(0.0);
            project_on_cone([f[0] - step * (v[0] + friction * slip), f[1] - step * v[1], f[2] - step * v[2]], friction)
        } else {
            let normal = (f[0] - step * v[0]).max(0.0);
            [normal, -friction * f[0] * given[0], -friction * f[0] * given[1]]
        };
        let distance = (0..3).fold(0.0, |sum, k| sum + (f[k] - nearest[k]).powi(2)).sqrt();
        (distance / self.impulse).max(-v[0] / self.speed) + nan
    }
}

/// The natural map of one contact. Near the tolerance it allows for the rounding of A f + b, whose terms have the size `sum`; see
/// [`largest_row_sum`]. The slip may be less by [`ROUNDING`] or by `least_slip` of that size; the lesser map counts.
pub(super) fn of_contact(
    scales: Scales,
    inverse_mass: f64,
    [f, v]: [[f64; 3]; 2],
    friction: f64,
    given: [f64; 2],
    least_slip: f64,
    sum: impl FnOnce() -> f64,
) -> f64 {
    let map = scales.natural_map(f, v, friction, given);
    if map <= SOLVED || map >= ABOVE_ROUNDING || map.is_nan() {
        return map;
    }
    let sum = sum();
    let with =
        |least_slip| scales.limited_by_rounding(sum, least_slip, inverse_mass, f).natural_map(f, v, friction, given);
    match with(ROUNDING) {
        map if map <= SOLVED || least_slip <= ROUNDING => map,
        map => map.min(with(least_slip)),
    }
}

/// The greater of two numbers; NaN if the first is NaN.
pub(super) fn max_or_nan(worst: f64, next: f64) -> f64 {
    if worst.is_nan() || next <= worst { worst } else { next }
}

/// x / scale, but zero for 0 / 0.
pub(crate) fn relative(x: f64, scale: f64) -> f64 {
    if x == 0.0 { 0.0 } else { x / scale }
}

/// The greatest Σ|A f| of up to three rows of one contact, plus the greatest `speed` without impulse of all rows that are coupled with them,
/// in units of `scale`. b is a small difference of such speeds, so it has their rounding. A is read by columns, so that the rows are summed
/// side by side.
pub(super) fn largest_row_sum(
    delassus: &[f64],
    f: &[f64],
    rows: Range<usize>,
    speed: impl Fn(usize) -> f64,
    scale: f64,
) -> f64 {
    let mut sums = [[0.0; 2]; 3];
    for (k, (column, f)) in delassus.chunks_exact(f.len().max(1)).zip(f).enumerate() {
        let speed = speed(k);
        for ([sum, coupled], a) in sums.iter_mut().zip(&column[rows.clone()]) {
            *sum += (a * f).abs();
            let own = if *a == 0.0 { 0.0 } else { speed };
            *coupled = if own > *coupled { own } else { *coupled };
        }
    }
    sums.iter().map(|[sum, coupled]| sum + coupled / scale).fold(0.0, f64::max)
}

/// V of each contact: the greatest speed of all contacts that are coupled with it, directly or through others. Each contact's speed follows
/// from its three rows of `drift`, in units of `scale`, with the allowed approach added. A normal velocity counts only if it points
/// downwards.
pub(super) fn speeds(drift: &[f64], scale: &[f64], coupled: impl Fn(usize, usize) -> bool, speeds: &mut Vec<f64>) {
    let size = |b: &[f64]| (b[0].min(0.0).powi(2) + b[1] * b[1] + b[2] * b[2]).sqrt() + 0.0 * b[0];
    speeds.clear();
    speeds.extend(drift.chunks_exact(3).zip(scale).map(|(b, scale)| size(b) * scale));
    let mut changed = true;
    while std::mem::take(&mut changed) {
        for i in 0..speeds.len() {
            for k in 0..speeds.len() {
                if speeds[k] > speeds[i] && coupled(i, k) {
                    speeds[i] = speeds[k];
                    changed = true;
                }
            }
        }
    }
}

/// Evaluates the certificate; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Evaluator {
    drift: Vec<f64>,
    ones: Vec<f64>,
    speeds: Vec<f64>,
}

impl Evaluator {
    /// The residual of an impulse and its velocity v = A f + b, both in the rows of the problem.
    pub fn evaluate(&mut self, problem: &Problem, law: Law, impulse: &[f64], velocity: &[f64]) -> Residual {
        let (m, stride) = (problem.rows(), 1 + problem.tangents);
        let contact = |rows: &[f64], i: usize, lifted: f64| {
            let mut all = [0.0; 3];
            all[..stride].copy_from_slice(&rows[i * stride..][..stride]);
            all[0] += lifted;
            all
        };
        let Evaluator { drift, ones, speeds: speed } = self;
        drift.clear();
        (0..problem.contacts).for_each(|i| drift.extend(contact(&problem.drift, i, approach_offset(problem, law, i))));
        let coupled = |i: usize, k: usize| {
            (i * stride..(i + 1) * stride)
                .any(|row| problem.delassus[row * m + k * stride..][..stride].iter().any(|a| *a != 0.0))
        };
        ones.clear();
        ones.resize(problem.contacts, 1.0);
        speeds(drift, ones, coupled, speed);
        let mut residual = Residual::default();
        for (i, &speed) in speed.iter().enumerate() {
            let approach = approach_offset(problem, law, i);
            let (f, v) = (contact(impulse, i, 0.0), contact(velocity, i, approach));
            let rows = i * stride..(i + 1) * stride;
            let inverse_mass = rows.clone().map(|row| problem.delassus[row * (m + 1)]).fold(0.0, f64::max);
            let (friction, given) = (problem.friction[i], problem.given_slip(i));
            let scales = Scales::of(speed, inverse_mass, f);
            let sum = || largest_row_sum(&problem.delassus, impulse, rows.clone(), |row| problem.drift[row].abs(), 1.0);
            // the solver counts less as rounding, so that its impulse also passes here, where A f + b rounds differently
            let least_slip = ROUNDING.max(m as f64 * f64::EPSILON);
            let map = of_contact(scales, inverse_mass, [f, v], friction, given, least_slip, sum);
            let stays = approach < 0.0
                && map < EXCUSED * scales.natural_map(f, v, friction, given)
                && v[0] - ROUNDING_OF_A * sum() < MISSED * approach;
            let map = if stays { map.max(1.0) } else { map };
            residual.natural_map = max_or_nan(residual.natural_map, map);
            let work = (f[0] * v[0]).abs();
            let signorini = if work == 0.0 { 0.0 } else { work / (scales.impulse * scales.speed) };
            let enters = -v[0] > MISSED * scales.speed && law != Law::SpringDamper; // springs give way
            residual.enters |= enters;
            let signorini = if enters { signorini.max(-v[0] / scales.speed) } else { signorini };
            residual.signorini = max_or_nan(residual.signorini, signorini);
            // a given direction of slip replaces the velocity: friction must oppose it
            let along = scales.speed.max(f64::MIN_POSITIVE);
            let slip = if given == [0.0; 2] { v } else { [v[0], given[0] * along, given[1] * along] };
            residual.misalignment = residual.misalignment.max(misalignment(f, slip, scales));
        }
        residual
    }
}

/// Angle between f_F and −v_F, zero unless both have a direction [rad].
fn misalignment(f: [f64; 3], v: [f64; 3], scales: Scales) -> f64 {
    if norm(f[1], f[2]) <= NO_DIRECTION * scales.impulse || norm(v[1], v[2]) <= NO_DIRECTION * scales.speed {
        return 0.0;
    }
    libm::atan2((f[1] * v[2] - f[2] * v[1]).abs(), -(f[1] * v[1] + f[2] * v[2]))
}
