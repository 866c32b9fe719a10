//! Springs and dampers in place of a contact law: f_N = h max(0, -k gap - c v_N), f_F = -μ f_N v_F/max(|v_F|, v_s).
//!
//! Gap and velocity are those before the step. With semi-implicit Euler, a mass m on such a spring is stable if and only if
//! ω h < 2 (√(1 + ζ²) - ζ), where ω² = k/m and c = 2 ζ √(k m). Then the roots of z² - (2 - ω²h² - 2 ζ ω h) z + (1 - 2 ζ ω h) lie in the unit
//! circle. Here m is the effective mass of the contact point, 1/A_NN. Below v_s friction is viscous, so a body that stands on a slope
//! creeps.

use super::super::problem::Problem;

/// Slip speed v_s above which friction is full [m/s].
const FULL_FRICTION_SPEED: f64 = 1e-2;

/// Writes the impulse [N·s].
pub(super) fn write_impulse(problem: &Problem, impulse: &mut Vec<f64>) {
    let (m, stride) = (problem.rows(), 1 + problem.tangents);
    let spring = problem.spring;
    impulse.clear();
    for i in 0..problem.contacts {
        let (row, v) = (i * stride, &problem.before[i * stride..][..stride]);
        let mobility = problem.delassus[row * m + row];
        let damping =
            if mobility > 0.0 { 2.0 * spring.damping_ratio * (spring.stiffness / mobility).sqrt() } else { 0.0 };
        let force = if problem.gap[i] < 0.0 { -spring.stiffness * problem.gap[i] - damping * v[0] } else { 0.0 };
        let normal = spring.h * force.max(0.0) + 0.0 * force; // the last term propagates NaN, which max hides
        let slip = v[1..].iter().fold(0.0, |slip: f64, v| libm::hypot(slip, *v));
        let share = problem.friction[i] * normal / slip.max(FULL_FRICTION_SPEED);
        impulse.push(normal);
        impulse.extend(v[1..].iter().map(|v| -share * v));
    }
}
