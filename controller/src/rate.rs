//! Resolved motion rate: joint rates from task rates by the QP (28)-(29).
//!
//! ```text
//!   minimise ½ q̇ᵀ C q̇ − c_0ᵀ q̇   subject to   J_aco q̇ = ẋ
//!   C = I + w s sᵀ,  c_0 = −w k φ s,  s = [0 1 1 1 1 1 1 0]
//! ```
//! The task has seven components and the robot eight joints. The remaining degree of freedom levels the swing foot: C and c_0 add
//! the cost ½ w (sᵀq̇ + k φ)², where φ is the pitch of the foot and sᵀq̇ its rate. The paper leaves C and c_0 to the designer and
//! suggests I and 0. With these the foot lands on its edge.

use crate::support::{Joints, TASK, TaskJacobian, TaskVector};
use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};
use messages::wire::JOINTS;
use nalgebra::SMatrix;

/// w: weight of the pitch of the swing foot [-].
const LEVEL_WEIGHT: f64 = 100.0;
/// k: rate at which the pitch of the swing foot decays [1/s].
pub(crate) const LEVEL_GAIN: f64 = 40.0;

/// A joint whose component of the null-space direction is smaller than this counts as fixed [-].
const LEAST_SHARE: f64 = 1e-12;
/// Tolerance of the interior-point method [-].
const INTERIOR_POINT_TOLERANCE: f64 = 1e-11;

/// s: 1 for each joint whose angle is part of the swing foot's pitch.
fn pitch_sum() -> Joints {
    Joints::from([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0])
}

/// w/(1 + w sᵀs).
fn share() -> f64 {
    LEVEL_WEIGHT / (1.0 + LEVEL_WEIGHT * pitch_sum().dot(&pitch_sum()))
}

/// c_0 of (28) for a swing foot with this pitch [rad].
pub fn bias(pitch: f64) -> Joints {
    -LEVEL_WEIGHT * LEVEL_GAIN * pitch * pitch_sum()
}

/// Joint rates without bounds, in closed form; `None` if J is singular. See [`RateSolver::rates`].
pub fn resolve(jacobian: &TaskJacobian, xdot: &TaskVector, bias: &Joints) -> Option<Joints> {
    RateSolver::new(jacobian)?.rates(xdot, bias)
}

/// Joint rates within bounds; `None` also if J is singular. See [`RateSolver::rates_within`].
pub fn resolve_bounded(
    jacobian: &TaskJacobian,
    xdot: &TaskVector,
    bias: &Joints,
    lower: &Joints,
    upper: &Joints,
) -> Option<Joints> {
    RateSolver::new(jacobian)?.rates_within(xdot, bias, lower, upper)
}

/// J C⁻¹ Jᵀ = L D Lᵀ of a posture, for any number of task rates. By the Sherman-Morrison formula C⁻¹ = I − share s sᵀ.
pub struct RateSolver<'a> {
    jacobian: &'a TaskJacobian,
    /// L D. Only the lower triangle is used.
    factor: SMatrix<f64, TASK, TASK>,
    /// The diagonal of D⁻¹.
    inverse: [f64; TASK],
}

impl<'a> RateSolver<'a> {
    /// `None` if J is singular.
    pub fn new(jacobian: &'a TaskJacobian) -> Option<RateSolver<'a>> {
        let pitch = jacobian * pitch_sum();
        let mut factor = pitch * pitch.transpose() * -share();
        for column in jacobian.column_iter() {
            for k in 0..TASK {
                for i in k..TASK {
                    factor[(i, k)] += column[i] * column[k];
                }
            }
        }
        let mut inverse = [0.0; TASK];
        for k in 0..TASK {
            if factor[(k, k)] <= 0.0 || factor[(k, k)].is_nan() {
                return None;
            }
            inverse[k] = 1.0 / factor[(k, k)];
            for j in k + 1..TASK {
                let ratio = factor[(j, k)] * inverse[k];
                for i in j..TASK {
                    factor[(i, j)] -= ratio * factor[(i, k)];
                }
            }
        }
        Some(RateSolver { jacobian, factor, inverse })
    }

    /// Joint rates without bounds; `None` if they are not finite.
    ///
    /// q̇ = C⁻¹(c_0 + Jᵀλ) with (J C⁻¹ Jᵀ) λ = ẋ − J C⁻¹ c_0. Shapes: J 7×8, ẋ 7, c_0 8. Source: (28), (29).
    pub fn rates(&self, xdot: &TaskVector, bias: &Joints) -> Option<Joints> {
        let (s, share) = (pitch_sum(), share());
        let unweigh = |v: &Joints| v - s * (share * s.dot(v));
        let free = unweigh(bias);
        let lambda = self.solve(xdot - self.jacobian * free);
        let rates = free + unweigh(&self.jacobian.tr_mul(&lambda));
        rates.iter().all(|rate| rate.is_finite()).then_some(rates)
    }

    /// Solves L D Lᵀ x = b.
    fn solve(&self, mut b: TaskVector) -> TaskVector {
        let RateSolver { factor, inverse, .. } = self;
        for k in 0..TASK {
            for j in k + 1..TASK {
                b[j] -= factor[(j, k)] * inverse[k] * b[k];
            }
        }
        for k in (0..TASK).rev() {
            let known: f64 = (k + 1..TASK).map(|j| factor[(j, k)] * b[j]).sum();
            b[k] = (b[k] - known) * inverse[k];
        }
        b
    }

    /// Joint rates within `lower` ≤ q̇ ≤ `upper` [rad/s]; `None` if no rates within the bounds satisfy (29).
    ///
    /// Seven equations for eight rates leave one direction n with J n = 0. The unbounded solution is stationary, so the objective grows
    /// as t² along n. The bounded solution is therefore the point between the bounds with the smallest |t|. It is exact up to rounding
    /// and needs no allocation.
    pub fn rates_within(&self, xdot: &TaskVector, bias: &Joints, lower: &Joints, upper: &Joints) -> Option<Joints> {
        let free = self.rates(xdot, bias)?;
        let s = pitch_sum();
        let direction = s - self.rates(&(self.jacobian * s), &Joints::zeros())?; // n
        let (mut least, mut most) = (f64::NEG_INFINITY, f64::INFINITY);
        for i in 0..JOINTS {
            let room = [lower[i] - free[i], upper[i] - free[i]];
            if direction[i].abs() < LEAST_SHARE {
                if room[0] > 0.0 || room[1] < 0.0 {
                    return None;
                }
                continue;
            }
            let [a, b] = room.map(|room| room / direction[i]);
            least = least.max(a.min(b));
            most = most.min(a.max(b));
        }
        // Rounding may leave a rate just outside its bound.
        let within =
            |t: f64| (free + direction * t).zip_zip_map(lower, upper, |rate: f64, low, high| rate.max(low).min(high));
        (least <= most).then(|| within(0.0_f64.max(least).min(most)))
    }
}

/// As [`resolve_bounded`], by an interior-point method, for comparison. It allocates. Each call makes a new solver, because a
/// solver that is updated in place gives different bits.
pub fn resolve_by_interior_points(
    jacobian: &TaskJacobian,
    xdot: &TaskVector,
    bias: &Joints,
    lower: &Joints,
    upper: &Joints,
) -> Option<Joints> {
    let s = pitch_sum();
    let weight = SMatrix::<f64, JOINTS, JOINTS>::identity() + LEVEL_WEIGHT * s * s.transpose();
    let hessian = CscMatrix::from(&rows(weight.upper_triangle().as_slice(), JOINTS, JOINTS));
    let mut constraints = rows(jacobian.as_slice(), TASK, JOINTS);
    for sign in [1.0, -1.0] {
        constraints
            .extend((0..JOINTS).map(|i| (0..JOINTS).map(|j| if i == j { sign } else { 0.0 }).collect::<Vec<_>>()));
    }
    let right: Vec<f64> = xdot.iter().chain(upper.iter()).copied().chain(lower.iter().map(|low| -low)).collect();
    let cones = [SupportedConeT::ZeroConeT(TASK), SupportedConeT::NonnegativeConeT(2 * JOINTS)];
    let settings = DefaultSettings {
        verbose: false,
        presolve_enable: false,
        tol_gap_abs: INTERIOR_POINT_TOLERANCE,
        tol_gap_rel: INTERIOR_POINT_TOLERANCE,
        tol_feas: INTERIOR_POINT_TOLERANCE,
        ..DefaultSettings::default()
    };
    let linear: Vec<f64> = bias.iter().map(|c| -c).collect();
    let mut solver =
        DefaultSolver::new(&hessian, &linear, &CscMatrix::from(&constraints), &right, &cones, settings).ok()?;
    solver.solve();
    matches!(solver.solution.status, SolverStatus::Solved | SolverStatus::AlmostSolved)
        .then(|| Joints::from_column_slice(&solver.solution.x))
}

/// The rows of a column-major matrix, the input format of the solver.
fn rows(column_major: &[f64], height: usize, width: usize) -> Vec<Vec<f64>> {
    (0..height).map(|i| (0..width).map(|j| column_major[i + j * height]).collect()).collect()
}
