//! Contact problems of mechanisms whose H is diagonal.

use biped_plant::contact::Problem;

pub const G: f64 = 9.81;
pub const H: f64 = 1e-3;
/// Contact points of a foot relative to its centre of mass, and the inverse of its H.
pub const CORNERS: [[f64; 3]; 4] = [[0.1, 0.04, -0.3], [0.1, -0.04, -0.3], [-0.06, 0.04, -0.3], [-0.06, -0.04, -0.3]];
pub const INVERSE: [f64; 6] = [1. / 14., 1. / 14., 1. / 14., 1. / 0.8, 1. / 0.7, 1. / 0.2];

/// One contact's rows of Kᵀ: normal, then the tangents x and y of the world.
pub type ContactRows = [Vec<f64>; 3];

/// A = KᵀH⁻¹K and b = Kᵀxdot of contacts with this number of tangents, from all rows of Kᵀ.
pub fn of_rows(tangents: usize, rows: &[Vec<f64>], inverse_inertia: &[f64], xdot: &[f64], mu: f64) -> Problem {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let mut problem = Problem::default();
    problem.reset(rows.len() / (1 + tangents), tangents);
    problem.friction.fill(mu);
    let m = problem.rows();
    for (i, row) in rows.iter().enumerate() {
        let weighted: Vec<f64> = row.iter().zip(inverse_inertia).map(|(k, h)| k * h).collect();
        for (j, other) in rows.iter().enumerate() {
            problem.delassus[i * m + j] = dot(&weighted, other);
        }
        problem.drift[i] = dot(row, xdot);
    }
    problem
}

/// The rows of a point r on a rigid body with coordinates (v, ω) at its centre of mass.
pub fn on_body([x, y, z]: [f64; 3]) -> ContactRows {
    [vec![0., 0., 1., y, -x, 0.], vec![1., 0., 0., 0., z, -y], vec![0., 1., 0., -z, 0., x]]
}

/// A moving foot whose contacts open and close: the touching contacts and the velocity at each step.
pub fn stirring_foot(steps: usize) -> impl Iterator<Item = (Vec<usize>, [f64; 6])> {
    let mut random = fastrand::Rng::with_seed(3);
    let mut xdot = [0.0, 0.0, -G * H, 0.0, 0.0, 0.0];
    let mut touching = vec![0, 1, 2, 3];
    (0..steps).map(move |step| {
        for (k, v) in xdot.iter_mut().enumerate() {
            let rest = if k == 2 { -G * H } else { 0.0 };
            *v += 0.02 * (rest - *v) + 2e-4 * (random.f64() - 0.5);
        }
        if step % 50 == 0 {
            touching = (0..4).filter(|_| random.f64() < 0.7).collect();
            random.shuffle(&mut touching);
        }
        (touching.clone(), xdot)
    })
}
