//! Exact answers of the comparison scenes, computed from the numbers of the scene.

mod motion;

pub use motion::{Ball, Puck, gravity};

use messages::scene::Scene;
use nalgebra::Vector3;

/// Time at which a body that is dropped from its clearance lands [s]; 0 without clearance.
pub fn landing(scene: &Scene) -> f64 {
    (2.0 * scene.initial.clearance.unwrap_or(0.0) / gravity(scene)[1]).sqrt()
}

/// Displacement and velocity of a body that slides or rests on the ground after its fall [m, m/s].
///
/// Its acceleration down the slope is g (sin α - μ cos α) if this is positive. Otherwise friction decelerates it by
/// μ g cos α - g sin α until it rests.
pub fn sliding(scene: &Scene, time: f64) -> [Vector3<f64>; 2] {
    let ([down, into], fall) = (gravity(scene), landing(scene));
    if time < fall {
        let drop = Vector3::new(0.0, 0.0, -into);
        return [drop * (0.5 * time * time), drop * time];
    }
    let start = Vector3::from(scene.initial.velocity);
    let lost = -into * 0.5 * fall * fall;
    let friction = scene.plant.friction * into;
    let (direction, speed) = (start.try_normalize(0.0).unwrap_or(Vector3::x()), start.norm());
    let gain = if speed == 0.0 { (down - friction).max(0.0) } else { down * direction.x - friction };
    let moving = if gain < 0.0 { (time - fall).min(-speed / gain) } else { time - fall };
    let displacement = direction * (speed * moving + 0.5 * gain * moving * moving) + Vector3::z() * lost;
    [displacement, direction * (speed + gain * moving)]
}

/// Ratio of the angular velocities after and before the impact of a rocking block (Housner).
pub fn rocking_ratio(width: f64, height: f64) -> f64 {
    1.0 - 1.5 * width * width / (width * width + height * height)
}

/// A rimless wheel that rolls down a slope, with all of its mass and inertia at the hub.
#[derive(Clone, Copy, Debug)]
pub struct Wheel {
    /// Length of a spoke [m].
    pub spoke: f64,
    /// Half the angle between spokes [rad].
    pub half: f64,
    /// Square of the ratio of gyration radius to spoke length [-].
    pub gyration: f64,
    /// Slope [rad].
    pub slope: f64,
    /// Gravity [m/s²].
    pub gravity: f64,
}

impl Wheel {
    /// The wheel of a scene. The tips of its spokes are the contact points of its one body.
    pub fn of(scene: &Scene) -> Wheel {
        let body = &scene.bodies[0];
        let radii = body.contacts.iter().map(|tip| tip[0].hypot(tip[2]));
        let spoke = radii.fold(0.0, f64::max);
        let sides = body.contacts.iter().filter(|tip| tip[1] == body.contacts[0][1]).count();
        Wheel {
            spoke,
            half: std::f64::consts::PI / sides as f64,
            gyration: body.moments()[1] / (body.mass * spoke * spoke),
            slope: scene.plant.incline_deg.to_radians(),
            gravity: scene.plant.gravity,
        }
    }

    /// Ratio of the angular velocities after and before an impact.
    pub fn ratio(&self) -> f64 {
        (self.gyration + (2.0 * self.half).cos()) / (1.0 + self.gyration)
    }

    /// d(ω²/2)/d(-cos φ), φ from the vertical [1/s²].
    fn pull(&self) -> f64 {
        self.gravity / (self.spoke * (1.0 + self.gyration))
    }

    /// Mean speed on the limit cycle [m/s]. A step has length 2 l sin(half) and duration ∫ dφ/ω.
    pub fn speed(&self) -> f64 {
        let (ratio, pull) = (self.ratio(), self.pull());
        let before = 4.0 * pull * self.half.sin() * self.slope.sin() / (1.0 - ratio * ratio);
        let [from, to] = [self.slope - self.half, self.slope + self.half];
        let rate = |angle: f64| (ratio * ratio * before + 2.0 * pull * (from.cos() - angle.cos())).sqrt();
        const PANELS: u32 = 200;
        let width = (to - from) / f64::from(PANELS);
        let simpson = |i: u32| {
            let left = from + width * f64::from(i);
            width / 6.0 * (1.0 / rate(left) + 4.0 / rate(left + 0.5 * width) + 1.0 / rate(left + width))
        };
        2.0 * self.spoke * self.half.sin() / (0..PANELS).map(simpson).sum::<f64>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_published_answers_come_out() {
        let wheel = Wheel {
            spoke: 0.3,
            half: std::f64::consts::PI / 8.0,
            gyration: 0.1 / 0.9,
            slope: 8f64.to_radians(),
            gravity: 9.81,
        };
        assert!((wheel.ratio() - 0.736396).abs() < 1e-6 && (wheel.speed() - 0.784571).abs() < 1e-6);
        assert!((rocking_ratio(0.1, 0.4) - 0.911764705882).abs() < 1e-12);
        let mut scene = Scene::default();
        scene.plant.friction = 0.5;
        scene.initial.velocity = [2.0, 0.0, 0.0];
        assert!((sliding(&scene, 1.0)[0].x - 0.407747).abs() < 1e-6);
        scene.initial.velocity = [0.0; 3];
        (scene.plant.incline_deg, scene.plant.friction) = (20.0, 0.3);
        assert!((sliding(&scene, 2.0)[0].x - 1.179404).abs() < 1e-6);
        (scene.plant.incline_deg, scene.plant.friction) = (26.0, 0.5);
        assert_eq!(sliding(&scene, 5.0), [Vector3::zeros(); 2]);
    }

    /// ω*⁻ of the point-mass wheel of one metre and slope .08 gives the speed .739806683 m/s.
    #[test]
    fn a_wheel_of_a_point_mass_rolls_at_its_known_speed() {
        let wheel = Wheel { spoke: 1.0, half: std::f64::consts::PI / 8.0, gyration: 0.0, slope: 0.08, gravity: 9.81 };
        assert!((wheel.speed() - 0.739806683).abs() < 1e-8, "{}", wheel.speed());
    }
}
