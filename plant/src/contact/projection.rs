//! Projection on the round cone. Coordinates are (normal, two tangents).

/// √(a² + b²), with the same bits on every machine.
#[inline(always)]
pub(super) fn norm(a: f64, b: f64) -> f64 {
    (a * a + b * b).sqrt()
}

/// Nearest point of the cone |x_F| <= μ x_N.
pub(super) fn project_on_cone(x: [f64; 3], mu: f64) -> [f64; 3] {
    let r = norm(x[1], x[2]);
    if x[0] >= 0.0 && r <= mu * x[0] {
        return x;
    }
    let edge = ((x[0] + mu * r) / (1.0 + mu * mu)).max(0.0);
    let along = if r > 0.0 { mu * edge / r } else { 0.0 };
    [edge, along * x[1], along * x[2]]
}

/// Derivative of [`project_on_cone`].
pub(super) fn projection_derivative(x: [f64; 3], mu: f64) -> [[f64; 3]; 3] {
    let r = norm(x[1], x[2]);
    let part = 1.0 / (1.0 + mu * mu);
    let edge = part * (x[0] + mu * r);
    if x[0] >= 0.0 && r <= mu * x[0] {
        return [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    }
    if edge <= 0.0 {
        return [[0.0; 3]; 3];
    }
    let along = [x[1] / r, x[2] / r];
    let normal = [part, part * mu * along[0], part * mu * along[1]];
    let turn = mu * edge / r;
    let tangent = |k: usize| {
        let mut row = normal.map(|p| mu * along[k] * p);
        (0..2).for_each(|c| row[1 + c] -= turn * along[k] * along[c]);
        row[1 + k] += turn;
        row
    };
    [normal, tangent(0), tangent(1)]
}

#[cfg(test)]
mod tests {
    use super::{project_on_cone, projection_derivative};
    use crate::contact::{Memory, Problem, Solver};
    use messages::scene::Law;

    /// Without friction the cone is a half line. A point behind its end has r = μ x_N = 0, as points of the cone have.
    #[test]
    fn a_contact_without_friction_that_separates_without_slip_does_not_pull() {
        assert_eq!(project_on_cone([-1.0, 0.0, 0.0], 0.0), [0.0; 3]);
        assert_eq!(projection_derivative([-1.0, 0.0, 0.0], 0.0), [[0.0; 3]; 3]);
        let mut problem = Problem::default();
        problem.reset(2, 2);
        let n = problem.rows();
        problem.delassus.iter_mut().step_by(n + 1).for_each(|a| *a = 1.0);
        (problem.delassus[3], problem.delassus[3 * n]) = (0.1, 0.1);
        problem.drift = vec![-1.0, 0.0, 0.0, 1.0, 0.0, 0.0];
        let mut solver = Solver::default();
        for law in [Law::Cone, Law::ConeQp] {
            let report = solver.solve(&problem, law, &mut Memory::default());
            assert!(!report.fallback && report.natural_map <= 1e-10, "{law:?}: {report:?}");
            assert!((solver.impulse[0] - 1.0).abs() < 1e-9 && solver.impulse[3].abs() < 1e-9, "{:?}", solver.impulse);
        }
        let pulls = solver.measure_impulse(&problem, Law::Cone, &[1.0 / 0.9, 0.0, 0.0, -1.0 / 0.9, 0.0, 0.0]);
        assert!(pulls.natural_map > 0.1, "a pulling impulse is no solution: {pulls:?}");
    }
}
