//! How well the impulses of welded links obey Coulomb's law: bounds on the residuals, for which nobody needs the matrix A.
//!
//! The impulses are within their cones, so that both the natural map and |f_N v_N| are no more than the velocity that is left makes
//! them. They are scaled by how easily each contact moves: no less than the whole robot's mass does, A_kk >= 1/m; or, where that is
//! too coarse, as Λ of its foot tells. The step's scale is no less than what pushes up, or would fall.

use super::foot::Foot;
use super::{Weld, velocity};
use crate::contact::{Report, SOLVED, relative};
use crate::detect::Touch;
use nalgebra::Vector3;

impl Weld {
    /// The residuals of the last solution, and its energy.
    pub(super) fn report(&self, touches: &[Touch], friction: f64, h: f64) -> Report {
        let [natural_map, signorini] = match self.round {
            true => [self.of_round_cones(touches, friction, h); 2],
            false => self.of_square_cones(touches, friction, h),
        };
        let work = |foot: &Foot| -> f64 {
            let pairs = foot.motion.iter().zip(&foot.free).zip(&foot.wrench);
            pairs.map(|((t, free), w)| w.dot(&(t + free))).sum()
        };
        let energy_gain = 0.5 * self.feet[..self.count].iter().map(work).sum::<f64>();
        let work = 0.5 * self.feet[..self.count].iter().map(|foot| work(foot).abs()).sum::<f64>();
        Report { natural_map, own: natural_map, signorini, energy_gain, work, warm: true, ..Report::default() }
    }

    /// The bounds for square cones; those that are called solved by the coarse bound are not measured by the finer one.
    fn of_square_cones(&self, touches: &[Touch], friction: f64, h: f64) -> [f64; 2] {
        // no contact moves less easily than the whole robot's mass does
        let least = Ease { per_fall: 0.0, ..Ease::of([1.0 / self.mass; 2]) };
        let coarse = self.residuals(touches, friction, h, |_, _| least);
        if coarse[0] > SOLVED {
            return self.residuals(touches, friction, h, |i, d| Ease::of(self.mobility.ease(i, d)));
        }
        coarse
    }

    /// The bound for round cones: the natural map of a contact, |f − P_K(f − (F/V) v̂)|/F, is no more than |v̂|/V, for no projection on a
    /// cone moves two points further apart; V is the greatest speed without impulse, as in the certificate of the full problem.
    fn of_round_cones(&self, touches: &[Touch], friction: f64, h: f64) -> f64 {
        let mut left = 0.0_f64;
        for foot in &self.feet[..self.count] {
            for (touch, d) in touches[foot.first..].iter().zip(&foot.sole.arms) {
                let v = velocity(&foot.motion, d);
                let (rise, slip) = ((v.z + touch.gap.max(0.0) / h).abs(), v.xy().norm());
                left = left.max((rise + friction * slip).hypot(slip));
            }
        }
        relative(left, self.speed(touches, h))
    }

    /// V: the greatest speed of a contact without impulse, downwards where it closes its gap within the step of `h`, and along the ground.
    pub(super) fn speed(&self, touches: &[Touch], h: f64) -> f64 {
        let mut speed = 0.0_f64;
        for foot in &self.feet[..self.count] {
            for (touch, d) in touches[foot.first..].iter().zip(&foot.sole.arms) {
                let v = velocity(&foot.free, d);
                speed = speed.max(v.xy().norm_squared() + (v.z + touch.gap.max(0.0) / h).min(0.0).powi(2));
            }
        }
        speed.sqrt()
    }

    /// Bounds on the natural map, and on |f_N v_N|, relative to the step's scale.
    fn residuals(
        &self,
        touches: &[Touch],
        friction: f64,
        h: f64,
        ease: impl Fn(usize, &Vector3<f64>) -> Ease,
    ) -> [f64; 2] {
        let (mut left, mut work, mut scale) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (k, foot) in self.feet[..self.count].iter().enumerate() {
            for (i, d) in (foot.first..).zip(&foot.sole.arms) {
                let Ease { up, per_up, per_along, per_fall } = ease(k, d);
                let (v, n, approach) = (velocity(&foot.motion, d), self.impulse[i].z, touches[i].gap.max(0.0) / h);
                let (rise, slip) = ((v.z + approach).abs(), v.x.abs() + v.y.abs());
                let (upwards, along) = ((rise + friction * slip) * per_up, slip * per_along);
                left = left.max(upwards * upwards + along * along); // no projection on a cone is longer
                work = work.max(n * rise);
                let fall = (velocity(&foot.free, d).z + approach).abs();
                scale = scale.max(n * up).max(fall * per_fall);
            }
        }
        [relative(left.sqrt(), scale), relative(work, scale * scale)]
    }
}

/// How easily a contact moves: roots of A_kk up and, in the worst direction, along, and what they divide by; what they divide a fall
/// by, if they are no mere bounds.
#[derive(Clone, Copy, Debug)]
struct Ease {
    up: f64,
    per_up: f64,
    per_along: f64,
    per_fall: f64,
}

impl Ease {
    fn of(mobility: [f64; 2]) -> Ease {
        let [up, along] = mobility.map(f64::sqrt);
        Ease { up, per_up: 1.0 / up, per_along: 1.0 / along, per_fall: 1.0 / up }
    }
}
