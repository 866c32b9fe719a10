//! Interior-point method for Coulomb's law. It needs no initial guess.
//!
//! With x = (μf_N, f_F) and y = (v_N/μ + |v_F|, v_F), Coulomb's law reads: x and y lie in the cone L = {x_N ≥ |x_F|}, and x·y = 0. The
//! method follows the points x∘y = τ(1, 0, 0) inside L while τ falls to zero. It decides the modes of all contacts together and guesses
//! none. With |v_F| held, the program is convex and the method converges. With |v_F| taken from y, including its derivative, it nearly
//! always converges.
//!
//! A contact with a given direction of slip has f_F = −μ f_N along it. Its only unknown is f_N, and its only condition is the one on v_N.
//!
//! # Source
//! Nesterov & Todd (1997): the scaling W, Wx = W⁻¹y. Mehrotra (1992): predictor and corrector. Acary, Armand & Nguyen (2022): the method
//! for frictional contact. El-Bakry, Tapia & Zhang (1994): indicators of the variables that vanish. Formulas of W: Vandenberghe, *The
//! CVXOPT linear and quadratic cone program solvers* (2010).

mod cone;

use super::super::lu::Lu;
use super::super::mode::ContactMode;
use super::super::projection::norm;
use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{COMPLIANCE, INTERIOR_PROGRESS, INTERIOR_RESIDUAL, MIN_TAU, WELL_SOLVED};
use super::iterate::{Guess, Iterate};
use cone::{Scaling, Vector, axpy, determinant, dot, jordan_product, jordan_solve, max_step};

/// Steps at most; 10 to 20 are typical.
const MAX_STEPS: u32 = 40;
/// Newton's method tries the indicated modes after this many steps in a row have indicated the same.
const STABLE_STEPS: u32 = 3;

/// A variable of which the predictor removes more than this part vanishes at the solution [-].
const TAPIA_THRESHOLD: f64 = 0.5;

/// Length of the steps, and how fast they reduce τ.
#[derive(Clone, Copy, Debug)]
pub(super) struct StepRule {
    /// Length of a step, relative to the step that reaches the boundary of the cones [-].
    step_fraction: f64,
    /// Least τ that a step aims at, relative to the present τ [-].
    min_centering: f64,
    /// Steps at most without progress. Where rounding stops the method, Newton's method or the next stage continues.
    patience: u32,
}

impl StepRule {
    pub const AGGRESSIVE: StepRule = StepRule { step_fraction: 0.99, min_centering: 1e-4, patience: 6 };
    pub const CAUTIOUS: StepRule = StepRule { step_fraction: 0.9, min_centering: 0.1, patience: MAX_STEPS };
}

/// One contact: x, y, and its step.
#[derive(Clone, Copy, Debug, Default)]
struct ConePair {
    x: Vector,
    y: Vector,
    scaling: Scaling,
    /// Derivative of |y_F|.
    gradient: Vector,
    /// Dual residual: A x + b + |y_F| − y.
    residual: Vector,
    dx: Vector,
    dy: Vector,
    /// Mode at the solution, as the last step indicates it.
    mode: ContactMode,
}

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct Interior {
    contacts: Vec<ConePair>,
    /// Weights of each contact, f = weight x: (1/μ, 1, 1), or (1, 0, 0) without friction or with a given direction of slip.
    weights: Vec<f64>,
    matrix: Vec<f64>,
    factor: Lu,
    right: Vec<f64>,
    best: Vec<f64>,
    /// The least residual so far.
    least: f64,
    /// Number of steps so far, and how many of the last ones have indicated the same modes.
    steps: u32,
    stable: u32,
    /// The least value so far of the greater of τ and residual, and the step that reached it.
    progress: (f64, u32),
}

impl Interior {
    /// Starts with x and y on the axes of the cones.
    pub fn start(&mut self, cones: &RoundCones) {
        self.contacts.clear();
        self.contacts
            .resize(cones.contacts, ConePair { x: [1.0, 0.0, 0.0], y: [1.0, 0.0, 0.0], ..ConePair::default() });
        self.weights.clear();
        self.weights.extend(cones.friction.iter().zip(&cones.slip_direction).flat_map(|(mu, given)| {
            match *mu > 0.0 && *given == [0.0; 2] {
                true => [1.0 / mu, 1.0, 1.0],
                false => [1.0, 0.0, 0.0],
            }
        }));
        (self.least, self.steps, self.stable, self.progress) = (f64::INFINITY, 0, 0, (f64::INFINITY, 0));
        self.best.clear();
        self.best.resize(self.weights.len(), 0.0);
    }

    /// Iterates towards the solution of Coulomb's law, or with held |v_F| to that of the convex program. Leaves the best iterate. Returns
    /// whether it has ended. Without `held` it also returns as soon as [`STABLE_STEPS`] steps have indicated the same modes.
    pub fn advance(&mut self, cones: &RoundCones, rule: StepRule, held: Option<&[f64]>, iterate: &mut Iterate) -> bool {
        let unit = if cones.size > 0.0 { cones.size } else { 1.0 };
        let mut ended = true;
        while self.steps < MAX_STEPS {
            self.steps += 1;
            self.write_impulse(cones, unit, &mut iterate.f);
            cones.velocity(&iterate.f, &mut iterate.v);
            let error = cones.residual(&iterate.f, &iterate.v);
            if error < self.least || held.is_some() {
                self.least = error;
                self.best.clone_from(&iterate.f);
            }
            let tau = self.contacts.iter().map(|own| dot(own.x, own.y)).sum::<f64>() / cones.contacts as f64;
            let residual = self.update_scaling(unit, held, &iterate.v);
            if tau.max(residual) < INTERIOR_PROGRESS * self.progress.0 {
                self.progress = (tau.max(residual), self.steps);
            }
            if held.is_none() && self.steps > self.progress.1 + rule.patience {
                break;
            }
            if self.least <= WELL_SOLVED || tau.is_nan() || tau < MIN_TAU && residual < INTERIOR_RESIDUAL {
                break;
            }
            iterate.steps += 1;
            if !self.factorize(cones) {
                break;
            }
            self.find_direction(None, tau);
            let changes = self.contacts.iter_mut().fold(false, |changes, own| own.predict_mode() | changes);
            self.stable = if changes { 1 } else { self.stable + 1 };
            let predicted_step = self.max_step();
            let share =
                if tau < MIN_TAU { 1.0 } else { (1.0 - predicted_step.min(1.0)).powi(3).max(rule.min_centering) };
            self.find_direction(Some(share), tau);
            let step = f64::min(1.0, rule.step_fraction * self.max_step());
            for own in &mut self.contacts {
                own.x = axpy(own.x, step, own.dx);
                own.y = axpy(own.y, step, own.dy);
            }
            if !self.contacts.iter().all(|own| determinant(own.x) > 0.0 && determinant(own.y) > 0.0) {
                break; // rounding moved a contact out of its cone
            }
            if held.is_none() && self.stable == STABLE_STEPS {
                ended = false;
                break;
            }
        }
        iterate.f.clone_from(&self.best);
        ended
    }

    /// Writes the indicated modes and slips as a guess for Newton's method.
    pub fn guess(&self, cones: &RoundCones, guess: &mut Guess) {
        guess.modes.clear();
        guess.slips.clear();
        for own in &self.contacts {
            guess.modes.push(own.mode);
            guess.slips.push([own.y[1] * cones.size, own.y[2] * cones.size]);
        }
    }

    /// f = weight x, and the friction along given directions of slip.
    fn write_impulse(&self, cones: &RoundCones, unit: f64, f: &mut [f64]) {
        for (i, (own, f)) in self.contacts.iter().zip(f.chunks_exact_mut(3)).enumerate() {
            (0..3).for_each(|k| f[k] = own.x[k] * self.weights[3 * i + k] * unit);
            (0..2).for_each(|k| f[1 + k] -= cones.friction[i] * cones.slip_direction[i][k] * f[0]);
        }
    }

    /// Updates scaling, gradient and dual residual; returns the greatest residual.
    fn update_scaling(&mut self, unit: f64, held: Option<&[f64]>, v: &[f64]) -> f64 {
        let mut largest: f64 = 0.0;
        for (i, own) in self.contacts.iter_mut().enumerate() {
            own.scaling = Scaling::of(own.x, own.y);
            let slip = norm(own.y[1], own.y[2]);
            own.gradient =
                if slip > 0.0 && held.is_none() { [0.0, own.y[1] / slip, own.y[2] / slip] } else { [0.0; 3] };
            let v = contact_rows(v, i);
            own.residual = [0, 1, 2].map(|k| self.weights[3 * i + k] * v[k] / unit - own.y[k]);
            own.residual[0] += held.map_or(slip, |held| held[i] / unit);
            largest = own.residual.iter().fold(largest, |largest, residual| largest.max(residual.abs()));
        }
        largest
    }

    /// Factorises A + ε + (1 − e gᵀ)W², with e the normal and g the gradient. The compliance ε keeps the matrix regular. The residual is
    /// that of rigid contacts, so the method ends at their solution.
    fn factorize(&mut self, cones: &RoundCones) -> bool {
        let Interior { contacts, weights, matrix, factor, .. } = self;
        let m = weights.len();
        matrix.clear();
        for (c, column) in weights.iter().enumerate() {
            let row = |k: usize| &cones.delassus[k * m..][..m];
            matrix.extend(row(c).iter().zip(&*weights).map(|(a, weight)| a * weight * column));
            if c % 3 == 0 && cones.slip_direction[c / 3] != [0.0; 2] {
                for (k, given) in (c + 1..).zip(cones.slip_direction[c / 3]) {
                    let follows = -cones.friction[c / 3] * given;
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

    /// Without `share`: the predictor, a direction to x∘y = 0. With it: the corrector, a direction to x∘y = share τ that includes the
    /// second-order term of the predictor.
    fn find_direction(&mut self, share: Option<f64>, tau: f64) {
        let Interior { contacts, factor, right, .. } = self;
        right.clear();
        for own in &mut *contacts {
            let scaled = own.scaling.apply(own.x);
            let mut target = jordan_product(scaled, scaled).map(|product| -product);
            if let Some(share) = share {
                target[0] += share * tau;
                let changed = jordan_product(own.scaling.apply_inverse(own.dy), own.scaling.apply(own.dx));
                target = axpy(target, -1.0, changed);
            }
            own.dy = own.scaling.apply(jordan_solve(scaled, target));
            let shifted = [own.dy[0] - dot(own.gradient, own.dy), own.dy[1], own.dy[2]];
            right.extend((0..3).map(|k| shifted[k] - own.residual[k]));
        }
        factor.solve(right);
        for (i, own) in contacts.iter_mut().enumerate() {
            own.dx = contact_rows(right, i);
            own.dy = axpy(own.dy, -1.0, own.scaling.apply(own.scaling.apply(own.dx)));
        }
    }

    /// Longest step along the direction that keeps all contacts inside their cones.
    fn max_step(&self) -> f64 {
        let within = |own: &ConePair| f64::min(max_step(own.x, own.dx), max_step(own.y, own.dy));
        self.contacts.iter().map(within).fold(f64::INFINITY, f64::min)
    }
}

impl ConePair {
    /// Tapia's indicators: the predictor removes nearly all of a variable that vanishes at the solution, and nearly nothing of any other.
    /// Returns whether the indicated mode changes.
    fn predict_mode(&mut self) -> bool {
        let [x, y] = [self.dx[0] / self.x[0], self.dy[0] / self.y[0]];
        let mode = match () {
            () if x < y && x < -TAPIA_THRESHOLD => ContactMode::Open,
            () if y < -TAPIA_THRESHOLD => ContactMode::Sticking,
            () => ContactMode::Sliding,
        };
        std::mem::replace(&mut self.mode, mode) != mode
    }
}
