//! Motions with a smooth equation but no closed solution: a sliding, turning puck and a rolling, loaded ball.
//!
//! The equation is integrated by the classical Runge-Kutta method with so many steps that only rounding remains.

use messages::scene::Scene;
use nalgebra::{Rotation2, Vector2, Vector3};

/// Components of gravity downhill and into the ground [m/s²].
pub fn gravity(scene: &Scene) -> [f64; 2] {
    let slope = scene.plant.incline_deg.to_radians();
    [scene.plant.gravity * slope.sin(), scene.plant.gravity * slope.cos()]
}

/// Number of steps. With half as many, no answer differs by 1e-12.
const STEPS: u32 = 16_000;

/// The state at `time`, starting from `state`, by the classical method of fourth order.
fn integrate<const N: usize>(state: [f64; N], time: f64, steps: u32, rate: impl Fn(&[f64; N]) -> [f64; N]) -> [f64; N] {
    let h = time / f64::from(steps);
    let ahead = |state: &[f64; N], slope: &[f64; N], by: f64| std::array::from_fn(|i| state[i] + by * slope[i]);
    (0..steps).fold(state, |state, _| {
        let first = rate(&state);
        let second = rate(&ahead(&state, &first, 0.5 * h));
        let third = rate(&ahead(&state, &second, 0.5 * h));
        let fourth = rate(&ahead(&state, &third, h));
        let mean: [f64; N] = std::array::from_fn(|i| (first[i] + 2.0 * (second[i] + third[i]) + fourth[i]) / 6.0);
        ahead(&state, &mean, h)
    })
}

/// A puck that slides and turns on legs that share its weight evenly. Friction opposes the velocity of each leg.
///
/// Three legs 120° apart share the weight evenly if the centre of mass lies in their middle at ground level: then friction has no
/// moment that would shift the loads.
#[derive(Clone, Debug)]
pub struct Puck {
    legs: Vec<Vector2<f64>>,
    /// Radius of gyration about the vertical, squared [m²].
    gyration: f64,
    /// Deceleration by friction without rotation [m/s²].
    friction: f64,
    velocity: [f64; 2],
    spin: f64,
}

/// Displacement of a puck.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PuckPose {
    /// Displacement of the centre of mass [m].
    pub displacement: Vector3<f64>,
    /// Angle by which the puck has turned [rad].
    pub yaw: f64,
}

impl Puck {
    /// The puck of a scene, its one body.
    pub fn of(scene: &Scene) -> Puck {
        let (body, start) = (&scene.bodies[0], &scene.initial);
        Puck {
            legs: body.contacts.iter().map(|leg| Vector2::new(leg[0], leg[1])).collect(),
            gyration: body.moments()[2] / body.mass,
            friction: scene.plant.friction * gravity(scene)[1],
            velocity: [start.velocity[0], start.velocity[1]],
            spin: start.angular_velocity[2],
        }
    }

    /// Displacement at a time before it comes to rest.
    pub fn at(&self, time: f64) -> PuckPose {
        let [x, y, yaw, ..] = self.after(time, STEPS);
        PuckPose { displacement: Vector3::new(x, y, 0.0), yaw }
    }

    /// Position and yaw, then their rates.
    fn after(&self, time: f64, steps: u32) -> [f64; 6] {
        let start = [0.0, 0.0, 0.0, self.velocity[0], self.velocity[1], self.spin];
        integrate(start, time, steps, |&[_, _, yaw, vx, vy, spin]| {
            let (turn, share) = (Rotation2::new(yaw), self.friction / self.legs.len() as f64);
            let (mut force, mut moment) = (Vector2::zeros(), 0.0);
            for leg in &self.legs {
                let arm = turn * leg;
                let velocity = Vector2::new(vx - spin * arm.y, vy + spin * arm.x);
                let friction = -share * velocity.normalize();
                force += friction;
                moment += arm.perp(&friction);
            }
            [vx, vy, spin, force.x, force.y, moment / self.gyration]
        })
    }
}

/// A ball with an eccentric centre of mass, released at rest, that rolls to and fro without slipping.
#[derive(Clone, Copy, Debug)]
pub struct Ball {
    /// Radius [m].
    pub radius: f64,
    /// Distance from its centre to its centre of mass [m].
    offset: f64,
    /// Radius of gyration about the centre of mass, squared [m²].
    gyration: f64,
    gravity: f64,
    /// Angle about y at the start, from where the centre of mass is lowest [rad].
    start: f64,
}

impl Ball {
    /// The ball of a scene, its one body.
    pub fn of(scene: &Scene) -> Ball {
        let body = &scene.bodies[0];
        Ball {
            radius: body.spheres.first().map_or(f64::NAN, |ball| ball.radius),
            offset: -body.com[2],
            gyration: body.moments()[1] / body.mass,
            gravity: scene.plant.gravity,
            start: scene.initial.orientation_deg[1].to_radians(),
        }
    }

    /// Angle after a time [rad].
    pub fn at(&self, time: f64) -> f64 {
        self.after(time, STEPS)[0]
    }

    /// Displacement of its centre of mass along x at an angle [m].
    pub fn displacement(&self, angle: f64) -> f64 {
        self.radius * (angle - self.start) - self.offset * (angle.sin() - self.start.sin())
    }

    /// Square of the distance of the centre of mass from the contact point, the instantaneous centre of rotation [m²].
    fn arm(&self, angle: f64) -> f64 {
        self.radius * self.radius + self.offset * self.offset - 2.0 * self.radius * self.offset * angle.cos()
    }

    /// φ and φ' after a time, by Lagrange's equation of ½ (k² + arm²) φ'² - g d (1 - cos φ).
    fn after(&self, time: f64, steps: u32) -> [f64; 2] {
        integrate([self.start, 0.0], time, steps, |&[angle, rate]| {
            let pull = self.offset * angle.sin() * (self.radius * rate * rate + self.gravity);
            [rate, -pull / (self.gyration + self.arm(angle))]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use messages::load::load;
    use shared::list::SCENES;

    fn scene(name: &str) -> Scene {
        load(name, &[], SCENES).expect(name)
    }

    #[test]
    fn with_half_as_many_steps_the_answers_are_the_same() {
        let (puck, ball) = (Puck::of(&scene("turn")), Ball::of(&scene("ball")));
        let [fine, coarse] = [STEPS, STEPS / 2].map(|steps| puck.after(0.5, steps));
        assert!(fine.iter().zip(coarse).all(|(fine, coarse)| (fine - coarse).abs() < 1e-12), "{fine:?} {coarse:?}");
        let [fine, coarse] = [STEPS, STEPS / 2].map(|steps| ball.after(1.75, steps)[0]);
        assert!((fine - coarse).abs() < 1e-12, "{fine} {coarse}");
    }

    #[test]
    fn the_published_answers_come_out() {
        let puck = Puck::of(&scene("turn"));
        let [_, _, yaw, vx, _, spin] = puck.after(0.5, STEPS);
        assert!((spin - 0.706_702).abs() < 1e-6 && (yaw - 0.431_227).abs() < 1e-6 && (vx - 1.019_870).abs() < 1e-6);
        let [angle, rate] = Ball::of(&scene("ball")).after(2.0, STEPS);
        assert!((angle + 1.198_763_45).abs() < 1e-8 && (rate - 0.290_818_29).abs() < 1e-8, "{angle} {rate}");
    }

    /// Without sliding the yaw rate falls by μ g r/k² per second; without rotation the puck slides as a cube does.
    #[test]
    fn a_puck_that_turns_alone_or_slides_alone_is_braked_evenly() {
        let puck = Puck::of(&scene("turn"));
        let turning = Puck { velocity: [0.0; 2], ..puck.clone() }.after(0.04, STEPS);
        assert!((turning[5] - (1.0 - 0.2 * 9.81 * 0.1 / 0.01 * 0.04)).abs() < 1e-12, "{turning:?}");
        let sliding = Puck { spin: 0.0, ..puck }.after(0.5, STEPS);
        assert!((sliding[0] - (2.0 * 0.5 - 0.5 * 0.2 * 9.81 * 0.25)).abs() < 1e-12, "{sliding:?}");
    }

    /// Its kinetic energy equals the potential energy that it has lost, at any time.
    #[test]
    fn a_ball_that_rolls_keeps_its_energy() {
        let ball = Ball::of(&scene("ball"));
        for time in [0.1, 0.2, 0.25, 1.0, 1.75] {
            let [angle, rate] = ball.after(time, STEPS);
            let fallen = ball.gravity * ball.offset * (angle.cos() - ball.start.cos());
            let motion = 0.5 * (ball.gyration + ball.arm(angle)) * rate * rate;
            assert!((motion - fallen).abs() < 1e-12, "{time}: {motion} {fallen}");
        }
    }
}
