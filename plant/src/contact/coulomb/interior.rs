//! Interior points: to a solution of Coulomb's law from no start at all.
//!
//! With x = (μf_N, f_F) and y = (v_N/μ + |v_F|, v_F) Coulomb's law asks for x and y in the cone L = {x_N ≥ |x_F|} and x·y = 0. The method
//! follows the points with x∘y = τ(1, 0, 0) inside L while τ falls to zero: all contacts decide together what they do, and none has to be
//! guessed. Where |v_F| is held as given the program is convex, and it arrives. Where |v_F| is that of y, whose derivative is taken along,
//! it nearly always does.
//!
//! A contact whose direction of slip is given has f_F = −μ f_N along it: its only unknown is f_N, its only condition that of v_N.
//!
//! # Source
//! Nesterov & Todd (1997): the scaling W, Wx = W⁻¹y. Mehrotra (1992): predictor and corrector. Acary, Armand & Nguyen (2022): the same
//! for frictional contact. El-Bakry, Tapia & Zhang (1994): what vanishes is seen in a step. Formulas of W: Vandenberghe, *The CVXOPT linear and quadratic cone program solvers* (2010).

mod cone;

use super::super::pivoted::Pivoted;
use super::super::project::length;
use super::super::round::{Round, part};
use super::super::tolerance::{COMPLIANCE, SOLVED};
use super::{Iterate, Kind, Start};
use cone::{Scaling, Vector, add, determinant, divide, dot, jordan, longest};

/// Steps at most; it takes 10 to 20.
const STEPS: u32 = 40;
/// τ falls no further than to this [-], the step's speed being 1: an impulse is then within 1e-10 of its cone, and Newton's method has the
/// rest. Below, the rounding of x decides whether it is inside.
const LEAST: f64 = 1e-20;
/// What y may lack in the end [-]: rounding.
const LACKS: f64 = 1e-13;

/// What the predictor takes more than this part of vanishes [-].
const HALF: f64 = 0.5;

/// How boldly τ is made to fall.
#[derive(Clone, Copy, Debug)]
pub(super) struct Pace {
    /// Part of the way to the border of the cones that a step goes [-].
    fraction: f64,
    /// Part of τ that a step leaves at least [-].
    leaves: f64,
}

impl Pace {
    pub const FAST: Pace = Pace { fraction: 0.99, leaves: 1e-4 };
    pub const SLOW: Pace = Pace { fraction: 0.9, leaves: 0.1 };
}

/// A contact of the problem: x, y, and its step.
#[derive(Clone, Copy, Debug, Default)]
struct Contact {
    x: Vector,
    y: Vector,
    scaling: Scaling,
    /// Derivative of |y_F|.
    gradient: Vector,
    /// What y lacks of A x + b + |y_F|.
    lacks: Vector,
    dx: Vector,
    dy: Vector,
    /// What it seems to do in the end.
    kind: Kind,
}

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Interior {
    contacts: Vec<Contact>,
    /// 1/μ, 1, 1 of each contact: f = weight x; 1, 0, 0 where friction is none, or follows f_N.
    weights: Vec<f64>,
    matrix: Vec<f64>,
    factor: Pivoted,
    right: Vec<f64>,
    best: Vec<f64>,
}

impl Interior {
    /// Goes to the solution, or as near as it comes; with |v_F| held, to that of the convex program.
    pub fn run(&mut self, round: &Round, pace: Pace, held: Option<&[f64]>, iterate: &mut Iterate) {
        let unit = if round.size > 0.0 { round.size } else { 1.0 };
        self.contacts.clear();
        self.contacts.resize(round.contacts, Contact { x: [1.0, 0.0, 0.0], y: [1.0, 0.0, 0.0], ..Contact::default() });
        self.weights.clear();
        self.weights.extend(round.friction.iter().zip(&round.given).flat_map(|(mu, given)| {
            match *mu > 0.0 && *given == [0.0; 2] {
                true => [1.0 / mu, 1.0, 1.0],
                false => [1.0, 0.0, 0.0],
            }
        }));
        self.best.clone_from(&iterate.f);
        let mut least = f64::INFINITY;
        for _ in 0..STEPS {
            self.write(round, unit, &mut iterate.f);
            round.velocity(&iterate.f, &mut iterate.v);
            let error = round.residual(&iterate.f, &iterate.v);
            if error < least || held.is_some() {
                least = error;
                self.best.clone_from(&iterate.f);
            }
            let tau = self.contacts.iter().map(|own| dot(own.x, own.y)).sum::<f64>() / round.contacts as f64;
            let lacks = self.measure(unit, held, &iterate.v);
            if least <= 0.5 * SOLVED || tau.is_nan() || tau < LEAST && lacks < LACKS {
                break;
            }
            iterate.steps += 1;
            if !self.factorize(round) {
                break;
            }
            self.direct(None, tau);
            self.contacts.iter_mut().for_each(Contact::foresee);
            let far = self.longest();
            let share = if tau < LEAST { 1.0 } else { (1.0 - far.min(1.0)).powi(3).max(pace.leaves) };
            self.direct(Some(share), tau);
            let step = f64::min(1.0, pace.fraction * self.longest());
            for own in &mut self.contacts {
                own.x = add(own.x, step, own.dx);
                own.y = add(own.y, step, own.dy);
            }
            if !self.contacts.iter().all(|own| determinant(own.x) > 0.0 && determinant(own.y) > 0.0) {
                break; // rounding took one out of its cone
            }
        }
        iterate.f.clone_from(&self.best);
    }

    /// What each contact does in the end, as the last step foresaw it.
    pub fn start(&self, round: &Round, groups: impl Iterator<Item = (usize, usize)>, start: &mut Start) {
        start.kinds.clear();
        start.slips.clear();
        for own in &self.contacts {
            start.kinds.push(own.kind);
            start.slips.push([own.y[1] * round.size, own.y[2] * round.size]);
        }
        for (first, end) in groups {
            let kinds = &mut start.kinds[first..end];
            let sticking = kinds.iter().filter(|kind| **kind == Kind::Sticks).count();
            if sticking > 1 && !kinds.contains(&Kind::Slides) {
                kinds.iter_mut().filter(|kind| **kind == Kind::Sticks).for_each(|kind| *kind = Kind::Patch);
            }
        }
    }

    /// f = weight x, and friction where it follows f_N.
    fn write(&self, round: &Round, unit: f64, f: &mut [f64]) {
        for (i, (own, f)) in self.contacts.iter().zip(f.chunks_exact_mut(3)).enumerate() {
            (0..3).for_each(|k| f[k] = own.x[k] * self.weights[3 * i + k] * unit);
            (0..2).for_each(|k| f[1 + k] -= round.friction[i] * round.given[i][k] * f[0]);
        }
    }

    /// Scaling, gradient, and what y lacks; returns the greatest of that.
    fn measure(&mut self, unit: f64, held: Option<&[f64]>, v: &[f64]) -> f64 {
        let mut most: f64 = 0.0;
        for (i, own) in self.contacts.iter_mut().enumerate() {
            own.scaling = Scaling::of(own.x, own.y);
            let slip = length(own.y[1], own.y[2]);
            own.gradient =
                if slip > 0.0 && held.is_none() { [0.0, own.y[1] / slip, own.y[2] / slip] } else { [0.0; 3] };
            let v = part(v, i);
            own.lacks = [0, 1, 2].map(|k| self.weights[3 * i + k] * v[k] / unit - own.y[k]);
            own.lacks[0] += held.map_or(slip, |held| held[i] / unit);
            most = own.lacks.iter().fold(most, |most, lacks| most.max(lacks.abs()));
        }
        most
    }

    /// The factor of A + ε + (1 − e gᵀ)W², e the normal, g the gradient. The compliance ε keeps the matrix regular; what y lacks is that
    /// of rigid contacts, so the method ends at their solution.
    fn factorize(&mut self, round: &Round) -> bool {
        let Interior { contacts, weights, matrix, factor, .. } = self;
        let m = weights.len();
        matrix.clear();
        for (c, column) in weights.iter().enumerate() {
            let row = |k: usize| &round.delassus[k * m..][..m];
            matrix.extend(row(c).iter().zip(&*weights).map(|(a, weight)| a * weight * column));
            if c % 3 == 0 && round.given[c / 3] != [0.0; 2] {
                for (k, given) in (c + 1..).zip(round.given[c / 3]) {
                    let follows = -round.friction[c / 3] * given;
                    let entries = matrix[c * m..].iter_mut().zip(row(k)).zip(&*weights);
                    entries.for_each(|((entry, a), weight)| *entry += a * weight * follows);
                }
            }
            let own = &contacts[c / 3];
            let mut unit = [0.0; 3];
            unit[c % 3] = 1.0;
            let [normal, along, across] = own.scaling.apply(own.scaling.apply(unit));
            let shifted = [normal - own.gradient[1] * along - own.gradient[2] * across, along, across];
            (0..3).for_each(|k| matrix[c * m + c / 3 * 3 + k] += shifted[k]);
            matrix[c * m + c] += column * column * COMPLIANCE;
        }
        factor.factorize(m, matrix, 0.0)
    }

    /// The direction to x∘y = 0; or, corrected by what that direction changed, to a part of τ.
    fn direct(&mut self, share: Option<f64>, tau: f64) {
        let Interior { contacts, factor, right, .. } = self;
        right.clear();
        for own in &mut *contacts {
            let scaled = own.scaling.apply(own.x);
            let mut aim = jordan(scaled, scaled).map(|product| -product);
            if let Some(share) = share {
                aim[0] += share * tau;
                let changed = jordan(own.scaling.undo(own.dy), own.scaling.apply(own.dx));
                aim = add(aim, -1.0, changed);
            }
            own.dy = own.scaling.apply(divide(scaled, aim));
            let shifted = [own.dy[0] - dot(own.gradient, own.dy), own.dy[1], own.dy[2]];
            right.extend((0..3).map(|k| shifted[k] - own.lacks[k]));
        }
        factor.solve(right);
        for (i, own) in contacts.iter_mut().enumerate() {
            own.dx = part(right, i);
            own.dy = add(own.dy, -1.0, own.scaling.apply(own.scaling.apply(own.dx)));
        }
    }

    /// How far the direction stays within the cones.
    fn longest(&self) -> f64 {
        let within = |own: &Contact| f64::min(longest(own.x, own.dx), longest(own.y, own.dy));
        self.contacts.iter().map(within).fold(f64::INFINITY, f64::min)
    }
}

impl Contact {
    /// The predictor takes what will be zero to nearly zero at once, and leaves what will not nearly as it is (Tapia's indicators).
    fn foresee(&mut self) {
        let [x, y] = [self.dx[0] / self.x[0], self.dy[0] / self.y[0]];
        self.kind = match () {
            () if x < y && x < -HALF => Kind::Open,
            () if y < -HALF => Kind::Sticks,
            () => Kind::Slides,
        };
    }
}
