//! Levenberg-Marquardt method for Coulomb's law: it reduces |F|², the natural map of [`natural_map`](super::natural_map).
//!
//! ```text
//!   (JᵀJ + λ) d = JᵀF;   f − d is taken if it reduces |F|;   then λ falls, else it grows
//! ```
//!
//! Newton's method with modes may go to and fro between sets of modes. Here |F| falls in every step, and a large λ shortens the step. A local
//! minimum of |F| that is no solution ends the run. The weight ρ decides where such minima are: feet that press against each other have none
//! at some weights, and stop there at others.
//!
//! # Source
//! Levenberg (1944), Marquardt (1963). Merit functions of semismooth equations: De Luca, Facchinei & Kanzow (1996).

use super::super::lu::Lu;
use super::super::round_cones::RoundCones;
use super::super::tolerance::{
    DAMPING_DECREASE, DAMPING_INCREASE, FIRST_DAMPING, LEAST_DAMPING, LEAST_SQUARES_ROUNDING, LEAST_SQUARES_STEPS,
    MAX_REJECTED,
};
use super::iterate::Iterate;
use super::natural_map::NaturalMap;

/// Workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct LeastSquares {
    present: NaturalMap,
    /// JᵀJ, JᵀJ + λ, and JᵀF.
    matrix: Vec<f64>,
    damped: Vec<f64>,
    gradient: Vec<f64>,
    factor: Lu,
    step: Vec<f64>,
    trial: Iterate,
    trial_map: NaturalMap,
}

impl LeastSquares {
    /// Reduces |F| from the present impulse as far as it falls.
    pub fn run(&mut self, cones: &RoundCones, weight: f64, iterate: &mut Iterate) {
        cones.velocity(&iterate.f, &mut iterate.v);
        let mut square = self.present.evaluate(cones, weight, &iterate.f, &iterate.v);
        let (mut damping, mut rejected) = (FIRST_DAMPING, 0);
        for _ in 0..LEAST_SQUARES_STEPS {
            if rejected == MAX_REJECTED || square.sqrt() <= LEAST_SQUARES_ROUNDING * cones.size {
                return;
            }
            if rejected == 0 {
                self.present.differentiate(cones, weight, &iterate.f, &iterate.v);
                self.square();
            }
            iterate.steps += 1;
            if !self.find_step(damping) {
                return;
            }
            let LeastSquares { present, step, trial, trial_map, .. } = self;
            trial.f.clear();
            trial.f.extend(iterate.f.iter().zip(step).map(|(f, d)| f - *d));
            cones.velocity(&trial.f, &mut trial.v);
            let trial_square = trial_map.evaluate(cones, weight, &trial.f, &trial.v);
            if trial_square < square {
                square = trial_square;
                std::mem::swap(&mut iterate.f, &mut trial.f);
                std::mem::swap(&mut iterate.v, &mut trial.v);
                std::mem::swap(&mut present.map, &mut trial_map.map);
                (damping, rejected) = (LEAST_DAMPING.max(damping * DAMPING_DECREASE), 0);
            } else {
                (damping, rejected) = (damping * DAMPING_INCREASE, rejected + 1);
            }
        }
    }

    /// JᵀJ and JᵀF.
    fn square(&mut self) {
        let LeastSquares { present: NaturalMap { map, derivative }, matrix, gradient, .. } = self;
        let n = map.len();
        matrix.clear();
        matrix.resize(n * n, 0.0);
        gradient.clear();
        gradient.resize(n, 0.0);
        for (row, map) in derivative.chunks_exact(n).zip(map) {
            gradient.iter_mut().zip(row).for_each(|(sum, entry)| *sum = entry.mul_add(*map, *sum));
            for (column, own) in matrix.chunks_exact_mut(n).zip(row).filter(|(_, own)| **own != 0.0) {
                column.iter_mut().zip(row).for_each(|(sum, entry)| *sum = entry.mul_add(*own, *sum));
            }
        }
    }

    /// Solves for d. False if a number is not finite.
    fn find_step(&mut self, damping: f64) -> bool {
        let LeastSquares { matrix, damped, gradient, factor, step, .. } = self;
        let n = gradient.len();
        damped.clone_from(matrix);
        damped.iter_mut().step_by(n + 1).for_each(|diagonal| *diagonal += damping);
        step.clone_from(gradient);
        let finite = factor.factorize(n, damped, 0.0);
        if finite {
            factor.solve(step);
        }
        finite
    }
}
