//! Natural map of Coulomb's law with round cones, and its derivative.
//!
//! ```text
//!   F(f) = f − P(x),   x = f − ρ (v + μ|v_F| n),   v = A f + b
//! ```
//!
//! P is the nearest point of the cones. F is zero exactly where the law holds, for every weight ρ > 0. Where the direction d of the slip is
//! given, F = (f_N − max(0, f_N − ρ v_N), f_F + μ f_N d).

use super::super::mode::ContactMode;
use super::super::projection::{norm, project_on_cone, projection_derivative};
use super::super::round_cones::{RoundCones, contact_rows};
use super::iterate::{Guess, Iterate};

/// The natural map at one impulse; workspace.
#[derive(Clone, Debug, Default)]
pub(super) struct NaturalMap {
    /// F.
    pub map: Vec<f64>,
    /// J = ∂F/∂f, row by row.
    pub derivative: Vec<f64>,
}

impl NaturalMap {
    /// Evaluates F with ρ = `weight` times the mass of each contact. Returns |F|².
    pub fn evaluate(&mut self, cones: &RoundCones, weight: f64, f: &[f64], v: &[f64]) -> f64 {
        self.map.clear();
        for i in 0..cones.contacts {
            let own = ContactMap::of(cones, weight, i, f, v);
            let nearest = match cones.slip_direction[i] {
                [0.0, 0.0] => project_on_cone(own.x, own.friction),
                given => [own.x[0].max(0.0), -own.friction * own.f[0] * given[0], -own.friction * own.f[0] * given[1]],
            };
            self.map.extend((0..3).map(|k| own.f[k] - nearest[k]));
        }
        self.map.iter().map(|map| map * map).sum()
    }

    /// J = 1 − P′ (1 − ρ (A + μ n eᵀA)), where e is the direction of slip.
    pub fn differentiate(&mut self, cones: &RoundCones, weight: f64, f: &[f64], v: &[f64]) {
        let n = f.len();
        self.derivative.clear();
        for i in 0..cones.contacts {
            let own = ContactMap::of(cones, weight, i, f, v);
            let given = cones.slip_direction[i];
            let projection = if given == [0.0; 2] {
                projection_derivative(own.x, own.friction)
            } else {
                [[if own.x[0] > 0.0 { 1.0 } else { 0.0 }, 0.0, 0.0], [0.0; 3], [0.0; 3]]
            };
            let [normal, along, across] = [0, 1, 2].map(|k| &cones.delassus[(3 * i + k) * n..][..n]);
            for (k, p) in projection.iter().enumerate() {
                let start = self.derivative.len();
                let weights = [p[0], p[1] + p[0] * own.shift[0], p[2] + p[0] * own.shift[1]].map(|p| p * own.rho);
                let columns = normal.iter().zip(along).zip(across);
                let entry = |((a, b), c): ((&f64, &f64), &f64)| weights[0] * a + weights[1] * b + weights[2] * c;
                self.derivative.extend(columns.map(entry));
                let row = &mut self.derivative[start + 3 * i..][..3];
                row.iter_mut().zip(p).for_each(|(entry, p)| *entry -= p);
                row[k] += 1.0;
                if k > 0 {
                    row[0] += own.friction * given[k - 1];
                }
            }
        }
    }
}

/// Modes and slips at an impulse: where x lies decides the mode.
pub(super) fn read_modes(cones: &RoundCones, weight: f64, Iterate { f, v, .. }: &Iterate, guess: &mut Guess) {
    guess.modes.clear();
    guess.slips.clear();
    for i in 0..cones.contacts {
        let ContactMap { x, friction, slip, .. } = ContactMap::of(cones, weight, i, f, v);
        let length = norm(x[1], x[2]);
        guess.modes.push(match () {
            () if friction * length <= -x[0] => ContactMode::Open,
            () if length <= friction * x[0] => ContactMode::Sticking,
            () => ContactMode::Sliding,
        });
        guess.slips.push(slip);
    }
}

/// One contact: its impulse, its slip, the point x, ρ, μ, and μ times the derivative of |v_F| by v_F.
struct ContactMap {
    f: [f64; 3],
    slip: [f64; 2],
    x: [f64; 3],
    rho: f64,
    friction: f64,
    shift: [f64; 2],
}

impl ContactMap {
    fn of(cones: &RoundCones, weight: f64, i: usize, f: &[f64], v: &[f64]) -> ContactMap {
        let (friction, rho) = (cones.friction[i], weight / cones.inverse_mass[i]);
        let (f, v) = (contact_rows(f, i), contact_rows(v, i));
        let slip = [v[1], v[2]];
        let speed = if cones.slip_direction[i] == [0.0; 2] { norm(v[1], v[2]) } else { 0.0 };
        let x = [f[0] - rho * (v[0] + friction * speed), f[1] - rho * v[1], f[2] - rho * v[2]];
        let shift = if speed > 0.0 { slip.map(|v| friction * v / speed) } else { [0.0; 2] };
        ContactMap { f, slip, x, rho, friction, shift }
    }
}

#[cfg(test)]
mod tests {
    use super::super::super::problem::Problem;
    use super::{NaturalMap, RoundCones};
    use crate::contact::{Memory, Solver};
    use fastrand::Rng;
    use messages::scene::Law;

    /// A problem with a random regular A, of two contacts without a given direction of slip and one with such a direction.
    fn problem(random: &mut Rng) -> Problem {
        let mut problem = Problem::default();
        problem.reset(3, 2);
        let n = problem.rows();
        let factor: Vec<f64> = (0..n * n).map(|_| random.f64() - 0.5).collect();
        for (k, a) in problem.delassus.iter_mut().enumerate() {
            *a = (0..n).map(|i| factor[k / n * n + i] * factor[k % n * n + i]).sum();
        }
        problem.friction = vec![0.2, 1.0, 0.5];
        problem.slip = vec![[0.0; 2], [0.0; 2], [0.6, -0.8]];
        problem.drift.iter_mut().for_each(|b| *b = 2.0 * random.f64() - 1.5);
        problem
    }

    #[test]
    fn the_derivative_equals_the_difference_quotient() {
        const STEP: f64 = 1e-6;
        let mut random = Rng::with_seed(11);
        let (mut cones, mut v, mut kinks) = (RoundCones::default(), vec![], 0);
        let [mut at, mut before, mut after] = <[NaturalMap; 3]>::default();
        for round in 0..300 {
            cones.set(&problem(&mut random), Law::Cone);
            let weight = [0.1, 1.0, 10.0][round % 3];
            let [f, d]: [Vec<f64>; 2] = std::array::from_fn(|_| (0..9).map(|_| 2.0 * random.f64() - 1.0).collect());
            for (map, step) in [(&mut before, -STEP), (&mut at, 0.0), (&mut after, STEP)] {
                let f: Vec<f64> = f.iter().zip(&d).map(|(f, d)| f + step * d).collect();
                cones.velocity(&f, &mut v);
                map.evaluate(&cones, weight, &f, &v);
                map.differentiate(&cones, weight, &f, &v);
            }
            for (k, row) in at.derivative.chunks_exact(9).enumerate() {
                let product: f64 = row.iter().zip(&d).map(|(j, d)| j * d).sum();
                let quotient = (after.map[k] - before.map[k]) / (2.0 * STEP);
                kinks += usize::from((product - quotient).abs() > 1e-5 * (1.0 + weight));
            }
        }
        assert!(kinks <= 3, "{kinks} of 2700 rows differ; a few may, where the nearest point changes its piece");
    }

    #[test]
    fn the_map_is_zero_at_a_solution_for_every_weight() {
        let mut random = Rng::with_seed(12);
        let (mut cones, mut map) = (RoundCones::default(), NaturalMap::default());
        let [mut f, mut v] = <[Vec<f64>; 2]>::default();
        for _ in 0..100 {
            let problem = problem(&mut random);
            let mut solver = Solver::default();
            if solver.solve(&problem, Law::Cone, &mut Memory::default()).fallback {
                continue; // a given direction of slip may leave no solution
            }
            cones.set(&problem, Law::Cone);
            cones.scale_impulse(&solver.impulse, &mut f);
            cones.velocity(&f, &mut v);
            for weight in [1e-3, 1.0, 1e3] {
                let size = map.evaluate(&cones, weight, &f, &v).sqrt();
                assert!(size <= 1e-9 * (1.0 + weight), "|F| = {size:.1e} with weight {weight}");
            }
            f[0] += 0.1;
            cones.velocity(&f, &mut v);
            assert!(map.evaluate(&cones, 1.0, &f, &v) > 1e-6, "another impulse is no solution");
        }
    }
}
