//! The contact problem for round cones: the rows of a contact are scaled alike, so that its cone stays round.

use super::certificate::{self, Scales, greater};
use super::project::{bounded, cone, greatest_slip, pyramid};
use super::residual::relative;
use super::scaled::{Scaled, respond};
use super::tolerance::{IMMOVABLE, SOLVED};
use super::{Problem, Report, lift};
use messages::scene::Law;

/// A natural map beyond this is not rounding, however large A f is [-].
const HIDDEN: f64 = 1e-3;

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

/// `v = A f + b`, three rows per contact (of one tangent the last is empty): f~ = s f, v~ = v/s with s^2 = A_NN [sqrt(J)].
#[derive(Clone, Debug, Default)]
pub(super) struct Round {
    pub contacts: usize,
    /// A~, 3 contacts square.
    pub delassus: Vec<f64>,
    /// b~, the allowed approach added to the normal rows; zero in directions that cannot move.
    pub drift: Vec<f64>,
    /// mu of each contact.
    pub friction: Vec<f64>,
    /// s of each contact.
    pub scale: Vec<f64>,
    /// Link of each contact.
    pub link: Vec<usize>,
    /// Direction of slip of each contact, where it is given; else zero.
    pub given: Vec<[f64; 2]>,
    /// Greatest entry of each contact's own diagonal of A~.
    pub inverse_mass: Vec<f64>,
    /// V of each contact [m/s]; see [`super::certificate`].
    speeds: Vec<f64>,
    /// Largest scaled drift.
    pub size: f64,
}

impl Round {
    /// Scales a problem; `lift` is what the law adds to v_N.
    pub fn set(&mut self, problem: &Problem, law: Law) {
        self.contacts = problem.contacts;
        let (n, m, stride) = (3 * problem.contacts, problem.rows(), 1 + problem.tangents);
        let greatest = (0..m).map(|k| problem.delassus[k * m + k]).fold(0.0, f64::max);
        let least = IMMOVABLE * greatest;
        let diagonal = |k: usize| problem.delassus[k * m + k];
        self.friction.clone_from(&problem.friction);
        self.scale.clear();
        self.scale.extend((0..problem.contacts).map(|i| {
            let rows = i * stride..(i + 1) * stride;
            let tangents = rows.clone().skip(1).map(diagonal).fold(0.0, f64::max);
            let own = if diagonal(rows.start) > least { diagonal(rows.start) } else { tangents };
            if own > least || own.is_nan() { own.sqrt() } else { 1.0 }
        }));
        self.delassus.clear();
        self.delassus.resize(n * n, 0.0);
        self.drift.clear();
        self.drift.resize(n, 0.0);
        for k in (0..m).filter(|&k| diagonal(k) > least || diagonal(k).is_nan()) {
            let (i, row) = (k / stride, k / stride * 3 + k % stride);
            let extra = if k % stride == 0 { lift(problem, law, i) } else { 0.0 };
            self.drift[row] = (problem.drift[k] + extra) / self.scale[i];
            for l in (0..m).filter(|&l| diagonal(l) > least || diagonal(l).is_nan()) {
                let column = l / stride * 3 + l % stride;
                let a = problem.delassus[k * m + l] / (self.scale[i] * self.scale[l / stride]);
                self.delassus[row * n + column] = a;
            }
        }
        self.size = self.drift.iter().fold(0.0, |size, b| b.abs().max(size));
        self.link.clear();
        self.link.extend((0..problem.contacts).map(|i| problem.link.get(i).copied().unwrap_or(i)));
        self.given.clear();
        self.given.extend((0..problem.contacts).map(|i| problem.given_slip(i)));
        self.inverse_mass.clear();
        let own = |i: usize| (3 * i..3 * i + 3).map(|k| self.delassus[k * n + k]).fold(0.0, f64::max);
        self.inverse_mass.extend((0..problem.contacts).map(|i| if own(i) > 0.0 { own(i) } else { 1.0 }));
        let Round { delassus, drift, scale, speeds, .. } = self;
        let coupled = |i: usize, k: usize| (3 * i..3 * i + 3).any(|row| delassus[row * n + 3 * k..][..3] != [0.0; 3]);
        certificate::speeds(drift, scale, coupled, speeds);
    }

    /// V of a contact, scaled.
    pub fn speed(&self, i: usize) -> f64 {
        self.speeds[i] / self.scale[i]
    }

    /// Natural map of Coulomb's law, contact by contact.
    pub fn residual(&self, f: &[f64], v: &[f64]) -> f64 {
        let mut worst = 0.0;
        for i in 0..self.contacts {
            let (own_f, own_v, inverse_mass) = (part(f, i), part(v, i), self.inverse_mass[i]);
            let scales = Scales::of(self.speed(i), inverse_mass, own_f);
            let mut map = scales.natural_map(own_f, own_v, self.friction[i], self.given[i]);
            if map > SOLVED && map < HIDDEN {
                let n = f.len();
                let row = |row: usize| self.delassus[row * n..][..n].iter().zip(f).map(|(a, f)| (a * f).abs()).sum();
                let known = (3 * i..3 * i + 3).map(row).fold(0.0, f64::max);
                map = scales.as_known(known, inverse_mass, own_f).natural_map(
                    own_f,
                    own_v,
                    self.friction[i],
                    self.given[i],
                );
            }
            worst = greater(worst, map);
        }
        worst
    }

    /// Becomes the problem of one proximal round: A + rho I, b - rho f.
    pub fn regularise(&mut self, original: &Round, rho: f64, f: &[f64]) {
        self.clone_from(original);
        self.delassus.iter_mut().step_by(f.len() + 1).for_each(|a| *a += rho);
        self.drift.iter_mut().zip(f).for_each(|(b, f)| *b -= rho * f);
    }

    /// Copies itself for [`super::facets`], of which the rows of a contact need not be scaled alike.
    pub fn copy_to(&self, scaled: &mut Scaled) {
        (scaled.contacts, scaled.tangents, scaled.size) = (self.contacts, 2, self.size);
        scaled.delassus.clone_from(&self.delassus);
        scaled.drift.clone_from(&self.drift);
        scaled.friction.clone_from(&self.friction);
        scaled.ratio.clear();
        scaled.ratio.resize(self.drift.len(), 1.0);
    }

    /// v~ = A~ f~ + b~.
    pub fn velocity(&self, f: &[f64], v: &mut Vec<f64>) {
        respond(&self.delassus, &self.drift, f, v);
    }

    /// Scales an impulse of the problem.
    pub fn read(&self, impulse: &[f64], f: &mut Vec<f64>) {
        let stride = impulse.len() / self.contacts.max(1);
        f.clear();
        f.resize(3 * self.contacts, 0.0);
        for (i, part) in impulse.chunks_exact(stride.max(1)).enumerate() {
            f[3 * i..].iter_mut().zip(part).for_each(|(f, part)| *f = part * self.scale[i]);
        }
    }

    /// Writes an impulse back in N·s.
    pub fn write(&self, problem: &Problem, f: &[f64], impulse: &mut Vec<f64>) {
        impulse.clear();
        for (f, scale) in f.chunks_exact(3).zip(&self.scale) {
            impulse.extend(f.iter().take(1 + problem.tangents).map(|f| f / scale));
        }
    }

    /// Natural map ||f - P_K(f - v^)||, the greatest entry, relative to the step's scale max(||f||, ||b||).
    pub fn natural_map(&self, rule: Rule<'_>, f: &[f64], v: &[f64]) -> f64 {
        let mut worst = 0.0_f64;
        for i in 0..self.contacts {
            let (f, v, mu) = (part(f, i), part(v, i), self.friction[i]);
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
        relative(worst, self.reach(f))
    }

    /// Step rho of a tangent impulse against a slip, the inverse of the greater tangent diagonal.
    pub fn tangent_step(&self, i: usize) -> f64 {
        let n = 3 * self.contacts;
        let diagonal = |k: usize| self.delassus[k * n + k];
        let greater = diagonal(3 * i + 1).max(diagonal(3 * i + 2));
        if greater > 0.0 { 1.0 / greater } else { 1.0 }
    }

    /// max(||f~||, ||b~||), the step's own scale [sqrt(J)].
    pub fn reach(&self, f: &[f64]) -> f64 {
        f.iter().fold(self.size, |size, f| size.max(f.abs()))
    }

    /// Fills the report's residuals: Coulomb's for a round cone, and the law's own.
    pub fn measure(&self, own: Rule<'_>, f: &[f64], v: &[f64], report: &mut Report) {
        report.natural_map = self.natural_map(Rule::Coulomb, f, v);
        report.own = self.natural_map(own, f, v);
        let scale = self.reach(f);
        let work = f.iter().zip(v).step_by(3).fold(0.0, |work: f64, (f, v)| work.max((f * v).abs()));
        report.signorini = relative(work, scale * scale);
        report.slip_misalignment =
            (0..self.contacts).map(|i| misalignment(part(f, i), part(v, i), scale)).fold(0.0, f64::max);
    }
}

/// The three rows of contact i.
pub(super) fn part(x: &[f64], i: usize) -> [f64; 3] {
    [x[3 * i], x[3 * i + 1], x[3 * i + 2]]
}

/// Angle between f_F and -v_F if both have a direction \[rad\].
fn misalignment(f: [f64; 3], v: [f64; 3], scale: f64) -> f64 {
    let least = super::residual::NO_DIRECTION * scale;
    if f[1].hypot(f[2]) <= least || v[1].hypot(v[2]) <= least {
        return 0.0;
    }
    (f[1] * v[2] - f[2] * v[1]).abs().atan2(-(f[1] * v[1] + f[2] * v[2]))
}
