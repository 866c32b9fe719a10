//! Semismooth Newton method on the conditions of all contacts at once.
//!
//! At each iterate a contact is open, sticks or slides, depending on the projection of its condition. That gives three linear equations P
//! df + Q dv = -r per contact. With dv = A df, the step is (P + Q A) df = -r. For Coulomb's law, the equations are those of Alart & Curnier
//! (1991), with x = f - rho v:
//!
//! | contact | condition | equations |
//! |---|---|---|
//! | open | x_N <= 0 | f = 0 |
//! | sticking | \|x_F\| <= μ x_N | v = 0 |
//! | sliding | else | v_N = 0, f_F = μ x_N x_F/\|x_F\| |
//!
//! Close to a solution the modes no longer change, and the steps converge quadratically. Far from it they may diverge. Then the method
//! keeps its best iterate, and [`super::cone_solver`] restarts it from a better point.

use super::super::round_cones::{RoundCones, contact_rows};
use super::super::tolerance::{SEMISMOOTH_ROUNDING, SOLVED, STEP_COMPLIANCES};
use super::condition::{Condition, natural_map, tangent_step};
use super::polygon::vertex;

/// Steps at most.
const MAX_STEPS: u32 = 25;
/// A step that reduces the residual to less than this part resets the patience [-].
const GOOD_PROGRESS: f64 = 0.1;
/// Steps without a better iterate before the method gives up.
const PATIENCE: u32 = 8;

type Matrix = [[f64; 3]; 3];
/// Rows of P, of Q, and of r.
type Row = ([f64; 3], [f64; 3], f64);

const ZERO: Matrix = [[0.0; 3]; 3];
const ONE: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

/// Workspace of one run.
#[derive(Clone, Debug, Default)]
pub(super) struct SemismoothNewton {
    matrix: Vec<f64>,
    right: Vec<f64>,
    best: Vec<f64>,
}

impl SemismoothNewton {
    /// Improves `f`, with its velocity `v`, down to rounding. Returns the least natural map of all iterates, and adds the steps to `steps`.
    pub fn polish(
        &mut self,
        cones: &RoundCones,
        condition: Condition<'_>,
        f: &mut Vec<f64>,
        v: &mut Vec<f64>,
        steps: &mut u32,
    ) -> f64 {
        cones.velocity(f, v);
        let mut least = natural_map(cones, condition, f, v);
        self.best.clone_from(f);
        for compliance in STEP_COMPLIANCES {
            self.run(cones, condition, compliance, &mut least, f, v, steps);
            f.clone_from(&self.best);
            cones.velocity(f, v);
            if least <= SOLVED {
                break;
            }
        }
        least
    }

    /// Steps with one compliance until the residual no longer falls. Keeps the best iterate and its residual.
    #[expect(clippy::too_many_arguments, reason = "problem, iterate and its residual")]
    fn run(
        &mut self,
        cones: &RoundCones,
        condition: Condition<'_>,
        rho: f64,
        least: &mut f64,
        f: &mut Vec<f64>,
        v: &mut Vec<f64>,
        steps: &mut u32,
    ) {
        let mut patience = PATIENCE;
        for _ in 0..MAX_STEPS {
            if *least <= SEMISMOOTH_ROUNDING || patience == 0 || !self.step(cones, condition, rho, f, v) {
                return;
            }
            *steps += 1;
            cones.velocity(f, v);
            let error = natural_map(cones, condition, f, v);
            // A solution gets one more step, to reach rounding.
            patience = if *least <= SOLVED { 0 } else { patience - 1 };
            if error < *least {
                patience = if error < GOOD_PROGRESS * *least { PATIENCE } else { patience.max(1) };
                *least = error;
                self.best.clone_from(f);
            }
        }
    }

    /// One full step; false if the equations are singular.
    fn step(&mut self, cones: &RoundCones, condition: Condition<'_>, rho: f64, f: &mut [f64], v: &[f64]) -> bool {
        let n = f.len();
        self.matrix.clear();
        self.matrix.resize(n * n, 0.0);
        self.right.clear();
        for i in 0..cones.contacts {
            let (p, q, r) = equations(cones, condition, i, contact_rows(f, i), contact_rows(v, i));
            for k in 0..3 {
                let row = &mut self.matrix[(3 * i + k) * n..][..n];
                for (l, &weight) in q[k].iter().enumerate().filter(|(_, weight)| **weight != 0.0) {
                    let a = &cones.delassus[(3 * i + l) * n..][..n];
                    row.iter_mut().zip(a).for_each(|(row, a)| *row += weight * a);
                    row[3 * i + l] += weight * rho;
                }
                row[3 * i..].iter_mut().zip(&p[k]).for_each(|(row, p)| *row += p);
                self.right.push(-r[k]);
            }
        }
        let solved = eliminate(&mut self.matrix, &mut self.right);
        if solved {
            f.iter_mut().zip(&self.right).for_each(|(f, df)| *f += df);
        }
        solved
    }
}

/// P, Q and r of contact i.
fn equations(
    cones: &RoundCones,
    condition: Condition<'_>,
    i: usize,
    f: [f64; 3],
    v: [f64; 3],
) -> (Matrix, Matrix, [f64; 3]) {
    let mu = cones.friction[i];
    if let Condition::Energy(shift) = condition {
        let v = [v[0] + shift.get(i).copied().unwrap_or(0.0), v[1], v[2]];
        return on_cone(mu, f, v);
    }
    let rho = tangent_step(cones, i);
    let x = [f[0] - v[0], f[1] - rho * v[1], f[2] - rho * v[2]];
    // The friction bound, and its derivative with respect to x_N.
    let (bound, slope) = match condition {
        Condition::Bound(bound) => (bound[i], 0.0),
        _ => (mu * x[0], mu),
    };
    if x[0] <= 0.0 && slope > 0.0 {
        return (ONE, ZERO, f);
    }
    let normal = if x[0] > 0.0 { (ZERO[0], ONE[0], v[0]) } else { (ONE[0], ZERO[0], f[0]) };
    let [first, second] = match condition {
        Condition::Polygon(d) => on_polygon(d, bound, slope, f, v, x),
        _ => on_disc(bound, slope, rho, f, v, x),
    };
    let rows = [normal, first, second];
    (rows.map(|row| row.0), rows.map(|row| row.1), rows.map(|row| row.2))
}

/// Equations of a sticking contact: no slip.
fn stick(v: [f64; 3]) -> [Row; 2] {
    [1, 2].map(|k| (ZERO[k], ONE[k], v[k]))
}

/// Friction in the disc |f_F| <= bound: no slip, or f_F = bound x_F/|x_F|.
fn on_disc(bound: f64, slope: f64, rho: f64, f: [f64; 3], v: [f64; 3], x: [f64; 3]) -> [Row; 2] {
    let length = libm::hypot(x[1], x[2]);
    if length <= bound {
        return stick(v);
    }
    let u = [x[1] / length, x[2] / length];
    let turn = bound / length;
    [0, 1].map(|k| {
        let across = [0, 1].map(|l| turn * (f64::from(k == l) - u[k] * u[l]));
        let p = [-slope * u[k], f64::from(k == 0) - across[0], f64::from(k == 1) - across[1]];
        (p, [slope * u[k], rho * across[0], rho * across[1]], f[k + 1] - bound * u[k])
    })
}

/// Friction in a polygon with `d` vertices at distance `bound`: no slip, in a vertex, or on a side.
fn on_polygon(d: usize, bound: f64, slope: f64, f: [f64; 3], v: [f64; 3], x: [f64; 3]) -> [Row; 2] {
    let sector = std::f64::consts::TAU / d as f64;
    let side = (libm::atan2(x[2], x[1]) / sector).floor().rem_euclid(d as f64) as usize;
    let (sin, cos) = libm::sincos((side as f64 + 0.5) * sector);
    let depth = libm::cos(0.5 * sector);
    let (across, along) = (cos * x[1] + sin * x[2], cos * x[2] - sin * x[1]);
    if across <= depth * bound {
        stick(v)
    } else if along.abs() < libm::sin(0.5 * sector) * bound {
        // On a side: no slip along it.
        let held = cos * f[1] + sin * f[2] - depth * bound;
        let still = cos * v[2] - sin * v[1];
        [([-slope * depth, cos, sin], [slope * depth, 0.0, 0.0], held), (ZERO[2], [0.0, -sin, cos], still)]
    } else {
        let end = vertex(d, if along > 0.0 { (side + 1) % d } else { side });
        [1, 2].map(|k| {
            let mut p = ONE[k];
            p[0] = -slope * end[k - 1];
            (p, [slope * end[k - 1], 0.0, 0.0], f[k] - bound * end[k - 1])
        })
    }
}

/// f = P_K(f - v) with the round cone: P = 1 - J, Q = J, where J is the derivative of the projection.
fn on_cone(mu: f64, f: [f64; 3], v: [f64; 3]) -> (Matrix, Matrix, [f64; 3]) {
    let x = [f[0] - v[0], f[1] - v[1], f[2] - v[2]];
    let length = libm::hypot(x[1], x[2]);
    if x[0] >= 0.0 && length <= mu * x[0] {
        return (ZERO, ONE, v);
    }
    let edge = (x[0] + mu * length) / (1.0 + mu * mu);
    if edge <= 0.0 {
        return (ONE, ZERO, f);
    }
    let u = [1.0, mu * x[1] / length, mu * x[2] / length];
    let turn = mu * edge / length;
    let (mut p, mut q, mut r) = (ONE, ZERO, [0.0; 3]);
    for k in 0..3 {
        for l in 0..3 {
            let mut j = u[k] * u[l] / (1.0 + mu * mu);
            if k > 0 && l > 0 && mu > 0.0 {
                j += turn * (f64::from(k == l) - u[k] * u[l] / (mu * mu));
            }
            q[k][l] = j;
            p[k][l] -= j;
        }
        r[k] = f[k] - edge * u[k];
    }
    (p, q, r)
}

/// Solves M x = b in place by elimination with partial pivoting; false if M is singular or not finite.
fn eliminate(matrix: &mut [f64], right: &mut [f64]) -> bool {
    let n = right.len();
    for k in 0..n {
        let size = |r: usize| matrix[r * n + k].abs();
        let best = (k + 1..n).fold(k, |best, r| if size(r) > size(best) { r } else { best });
        if !(size(best) > 0.0 && size(best).is_finite()) {
            return false;
        }
        if best != k {
            (k..n).for_each(|c| matrix.swap(k * n + c, best * n + c));
            right.swap(k, best);
        }
        let (upper, lower) = matrix.split_at_mut((k + 1) * n);
        let pivot = &upper[k * n + k..];
        for (i, row) in lower.chunks_exact_mut(n).enumerate() {
            let factor = row[k] / pivot[0];
            if factor != 0.0 {
                row[k..].iter_mut().zip(pivot).for_each(|(x, u)| *x -= factor * u);
                right[k + 1 + i] -= factor * right[k];
            }
        }
    }
    for k in (0..n).rev() {
        let known: f64 = matrix[k * n + k + 1..(k + 1) * n].iter().zip(&right[k + 1..]).map(|(u, x)| u * x).sum();
        right[k] = (right[k] - known) / matrix[k * n + k];
    }
    right.iter().all(|x| x.is_finite())
}
