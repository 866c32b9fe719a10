//! Dynamic similarity of two bipeds, and the posture of one that corresponds to that of the other.
//!
//! Robots of the same shape move in the same way if lengths are proportional to L, masses to M and times to √(L/g). Then their Froude
//! numbers v²/gL are equal. L is the height of the centre of gravity, which is the length of the pendulum of (31), (32).

use super::{BIPED, Body};
use nalgebra::{Matrix2, Vector2};

/// Pitch of a foot that counts as rounding [rad].
const PITCH_ROUNDING: f64 = 1e-9;
/// Accuracy of the centre of gravity, over the scale of lengths [m].
const COM_TOLERANCE: f64 = 1e-12;
/// Iterations of Newton's method. The limit only ends a search that has no solution.
const MAX_ITERATIONS: usize = 50;
/// Largest step of an iteration [rad].
const MAX_STEP: f64 = 0.5;

/// Ratios of one biped's length and mass to another's. They are exactly 1 for equal robots.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SimilarityScale {
    /// Ratio of the heights of the centres of gravity with straight legs [-].
    pub length: f64,
    /// Ratio of the masses [-].
    pub mass: f64,
}

impl SimilarityScale {
    /// The scale from one biped to another, both in the order of [`BIPED`].
    pub fn between(from: &[Body], to: &[Body]) -> SimilarityScale {
        let height = |bodies: &[Body]| Stance::of(bodies).com([0.0; 2]).y;
        let mass = |bodies: &[Body]| bodies.iter().map(|body| body.mass).sum::<f64>();
        SimilarityScale { length: height(to) / height(from), mass: mass(to) / mass(from) }
    }

    /// Ratio of times, √L [-].
    pub fn time(self) -> f64 {
        self.length.sqrt()
    }

    /// Ratio of speeds, L/√L [-].
    pub fn speed(self) -> f64 {
        self.length / self.time()
    }

    /// Ratio of torques, M L [-].
    pub fn torque(self) -> f64 {
        self.mass * self.length
    }

    /// Ratio of moments of inertia, M L² [-].
    pub fn inertia(self) -> f64 {
        self.mass * self.length * self.length
    }
}

/// Joint angles at which `to` stands as `from` does at `joints`: feet flat, trunk upright, centre of gravity over the corresponding
/// point of the soles, its height scaled. If `joints` is not such a posture, it is returned unchanged.
///
/// # Errors
/// If no knee angle brings the centre of gravity to that point.
pub fn stance(from: &[Body], joints: &[f64], to: &[Body]) -> Result<Vec<f64>, String> {
    let [roll, ankle, knee, hip, right @ ..] = joints else { return Ok(joints.to_vec()) };
    let stands = *roll == 0.0 && (ankle + knee + hip).abs() < PITCH_ROUNDING && *right == [-hip, -knee, -ankle, 0.0];
    if !stands {
        return Ok(joints.to_vec());
    }
    let before = [-hip, -hip - knee];
    let scale = SimilarityScale::between(from, to).length;
    let target = scale * Stance::of(from).com(before);
    let lean = Stance::of(to)
        .lean(target, before, COM_TOLERANCE * scale)
        .ok_or_else(|| format!("no knee angle brings its centre of gravity to {:.3} m above the soles", target.y))?;
    if lean == before {
        return Ok(joints.to_vec());
    }
    let [thigh, shank] = lean;
    let (ankle, knee, hip) = (shank, thigh - shank, -thigh);
    Ok(vec![0.0, ankle, knee, hip, -hip, -knee, -ankle, 0.0])
}

/// Position of the centre of gravity over the centre of the soles as a function of the leans of thigh and shank, in the plane of x and
/// z: c = w + R(θ_t) u + R(θ_s) v. The trunk is upright and both legs have the same angles [m].
struct Stance {
    fixed: Vector2<f64>,
    thigh: Vector2<f64>,
    shank: Vector2<f64>,
}

impl Stance {
    /// The function for bodies in the order of [`BIPED`]. For other bodies the result has no meaning.
    fn of(bodies: &[Body]) -> Stance {
        let flat = |[x, _, z]: [f64; 3]| Vector2::new(x, z);
        let body = |k: usize| bodies.get(k).filter(|_| bodies.len() == BIPED.len());
        let mass = |k: usize| body(k).map_or(0.0, |body| body.mass);
        let com = |k: usize| body(k).map_or(Vector2::zeros(), |body| flat(body.com));
        let at =
            |k: usize| body(k).and_then(|body| body.joint.as_ref()).map_or(Vector2::zeros(), |joint| flat(joint.at));
        let corners = body(0).map_or(&[][..], |foot| &foot.contacts);
        let sole = corners.iter().copied().map(flat).sum::<Vector2<f64>>() / corners.len().max(1) as f64;
        let total: f64 = (0..BIPED.len()).map(mass).sum();
        let (feet, legs) = (mass(0) + mass(1), mass(0) + mass(1) + mass(2) + mass(3));
        let below = mass(1) * com(1) + mass(0) * (at(0) + com(0));
        Stance {
            fixed: (2.0 * (legs * at(3) + below) + mass(4) * com(4)) / total - at(3) - at(0) - sole,
            thigh: 2.0 * (mass(3) * com(3) + (mass(2) + feet) * at(2)) / total - at(2),
            shank: 2.0 * (mass(2) * com(2) + feet * at(1)) / total - at(1),
        }
    }

    /// The centre of gravity for these leans of thigh and shank about y [rad].
    fn com(&self, [thigh, shank]: [f64; 2]) -> Vector2<f64> {
        self.fixed + rotated(self.thigh, thigh) + rotated(self.shank, shank)
    }

    /// Leans that bring the centre of gravity to within `tolerance` [m] of the target, by Newton's method.
    fn lean(&self, target: Vector2<f64>, guess: [f64; 2], tolerance: f64) -> Option<[f64; 2]> {
        let mut lean = guess;
        for _ in 0..MAX_ITERATIONS {
            let miss = target - self.com(lean);
            if miss.amax() <= tolerance {
                return (lean[0] < lean[1]).then_some(lean); // the knees must point forward
            }
            let quarter = std::f64::consts::FRAC_PI_2;
            let slope = Matrix2::from_columns(&[
                rotated(self.thigh, lean[0] + quarter),
                rotated(self.shank, lean[1] + quarter),
            ]);
            let step = slope.lu().solve(&miss)?;
            lean = [lean[0] + step.x.clamp(-MAX_STEP, MAX_STEP), lean[1] + step.y.clamp(-MAX_STEP, MAX_STEP)];
        }
        None
    }
}

/// A vector in the plane of x and z, rotated about y.
fn rotated(v: Vector2<f64>, angle: f64) -> Vector2<f64> {
    let (sin, cos) = libm::sincos(angle);
    Vector2::new(v.x * cos + v.y * sin, v.y * cos - v.x * sin)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::{CROUCH, table_1};

    #[test]
    fn the_centre_of_gravity_of_table_1_has_the_known_height() {
        let stance = Stance::of(&table_1());
        assert!((stance.com([0.0; 2]).y - 0.3196).abs() < 5e-5);
        let crouched = stance.com([-CROUCH[3], -CROUCH[3] - CROUCH[2]]);
        assert!((crouched - Vector2::new(0.0, 0.27)).amax() < 1e-4, "{crouched}");
    }

    #[test]
    fn the_scale_of_equal_robots_is_exactly_1_and_a_similar_robot_stands_at_the_same_angles() {
        let (robot, mut big) = (table_1(), table_1());
        assert_eq!(SimilarityScale::between(&robot, &robot), SimilarityScale { length: 1.0, mass: 1.0 });
        assert_eq!(stance(&robot, &CROUCH, &robot), Ok(CROUCH.to_vec()));
        for body in &mut big {
            body.mass *= 3.375;
            body.com = body.com.map(|x| 1.5 * x);
            body.contacts.iter_mut().for_each(|point| *point = point.map(|x| 1.5 * x));
            if let Some(joint) = &mut body.joint {
                joint.at = joint.at.map(|x| 1.5 * x);
            }
        }
        let scale = SimilarityScale::between(&robot, &big);
        assert!((scale.length - 1.5).abs() < 1e-14 && (scale.mass - 3.375).abs() < 1e-14);
        assert_eq!(stance(&robot, &CROUCH, &big), Ok(CROUCH.to_vec()));
    }

    #[test]
    fn a_robot_of_another_shape_stands_over_its_soles() {
        let (robot, mut other) = (table_1(), table_1());
        for shank in [2, 6] {
            other[shank].com[2] = -0.12;
            other[shank - 1 + usize::from(shank == 6) * 2].joint.as_mut().expect("an ankle").at[2] = -0.24;
        }
        let joints = stance(&robot, &CROUCH, &other).expect("a stance");
        let there = Stance::of(&other).com([-joints[3], -joints[3] - joints[2]]);
        let height = 0.27 * SimilarityScale::between(&robot, &other).length;
        assert!((there - Vector2::new(0.0, height)).amax() < 1e-4, "{there} for {height}");
        assert!((joints[1] + joints[2] + joints[3]).abs() < 1e-15 && joints[2] < -0.5, "{joints:?}");
    }
}
