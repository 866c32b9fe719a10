//! Input of a step: robot, settings of the scene, torques, pushes, and the ground under the contact points.

use crate::contact::{ContactSpring, Problem, Report, has_basis, is_coulomb, is_plastic};
use crate::error::PlantError;
use crate::ground::GroundHeights;
use crate::model::Model;
use messages::scene::{Law, Method, PlantScene, Scene};
use messages::wire::Torques;
use nalgebra::Vector3;

/// Energy gain of plastic contact that is accepted, relative to the work of its impulses [-]: the sum of residuals of 1e-10 at many
/// contacts.
const ENERGY_GAIN: f64 = 1e-8;

/// Input of a step. A step changes only [`Input::ground`].
pub(super) struct World {
    pub model: Model,
    pub settings: Settings,
    pub input: Input,
}

/// Forces that act on the robot from outside, the time, and the ground.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Input {
    /// Torques of the drives.
    pub torques: Torques,
    /// Pushes of the scene, and those requested during the run.
    pub pushes: Vec<Push>,
    /// Number of steps so far.
    pub steps: u64,
    /// The ground that the contact points meet. It depends on the heights at which they stood before: [`Plant::find_ground`].
    pub ground: GroundHeights,
}

/// Settings of the integration.
#[derive(Debug)]
pub(super) struct Settings {
    pub h: f64,
    pub steps_per_period: u64,
    pub law: Law,
    pub tolerance: f64,
    pub method: Method,
    pub friction: f64,
    pub restitution: f64,
    pub spring: ContactSpring,
    /// Whether to try the case that all feet stand.
    pub standing_feet: bool,
    pub tolerance_step: f64,
}

/// A force on a body's centre of mass for some steps.
#[derive(Clone, Debug, serde::Serialize, serde::Deserialize)]
pub(super) struct Push {
    pub link: usize,
    pub force: Vector3<f64>,
    pub steps: std::ops::Range<u64>,
}

impl Push {
    /// An impulse [N·s] on a link, spread over steps of `h` [s].
    pub fn new(link: usize, impulse: [f64; 3], steps: std::ops::Range<u64>, h: f64) -> Push {
        let count = steps.end - steps.start;
        Push { link, force: Vector3::from(impulse) / (count as f64 * h), steps }
    }
}

impl World {
    /// The world of a scene at time zero.
    ///
    /// # Errors
    /// As [`Model::new`] and [`Settings::new`]; or if the pushed body is unknown.
    pub fn new(scene: &Scene) -> Result<World, PlantError> {
        let (model, plant) = (Model::new(scene)?, &scene.plant);
        let link = model.link_of(&plant.push_body, "plant.push_body")?;
        let push = Push::new(link, plant.push_impulse, plant.push_steps(), plant.dt);
        let pushes = if plant.push_impulse == [0.0; 3] { vec![] } else { vec![push] };
        let settings = Settings::new(plant, scene.rate)?;
        let ground = GroundHeights::plane(&model);
        let input = Input { torques: Torques::default(), pushes, steps: 0, ground };
        Ok(World { model, settings, input })
    }

    /// Simulated time at the beginning of the step [s].
    pub fn time(&self) -> f64 {
        self.input.steps as f64 * self.settings.h
    }

    /// Checks that contact has not raised the energy: f·v − f·A f/2 is never positive, for sliding and landing contacts alike. Rounding is
    /// relative to the work of the impulses.
    pub fn check_energy(&self, report: &Report) -> Result<(), PlantError> {
        let law = self.settings.law;
        if is_plastic(law) && !self.is_dissipative(report) {
            let (time, gain) = (self.time(), report.energy_gain);
            return Err(PlantError::GainsEnergy { time, law, gain, residual: report.own });
        }
        Ok(())
    }

    /// Whether a solution has not raised the energy, except by rounding.
    pub fn is_dissipative(&self, report: &Report) -> bool {
        report.energy_gain <= ENERGY_GAIN * report.work
    }

    /// Checks that a step meets the scene's tolerance. A problem with numbers that are not finite passes: the check of the state reports
    /// it.
    pub fn check(&self, report: &Report, problem: &Problem) -> Result<(), PlantError> {
        let Settings { law, tolerance, .. } = self.settings;
        if report.own <= tolerance || !has_basis(law) || problem.check().is_err() {
            return Ok(());
        }
        let (step, time, problem) = (self.input.steps, self.time(), Box::new(problem.clone()));
        Err(PlantError::Unsolved { step, time, law, residual: report.own, tolerance, problem })
    }
}

impl Settings {
    /// The settings of a scene.
    ///
    /// # Errors
    /// If the method does not support the law, or method and law do not support restitution.
    pub fn new(plant: &PlantScene, rate: f64) -> Result<Self, PlantError> {
        let law = plant.law;
        if plant.method.locates_events() && !is_coulomb(law) {
            let rule = "one whose forces are Coulomb's: Complementarity, Aligned, Facets(n), Cone or FixedPoint";
            return Err(PlantError::value(format!("plant.law of the method {:?}", plant.method), law, rule));
        }
        if law == Law::SpringDamper && !plant.ground.is_plane() {
            let rule =
                "another law, because its springs would throw up a point that enters a higher tile from the side";
            return Err(PlantError::value("plant.law on uneven ground (plant.ground)", law, rule));
        }
        if plant.restitution > 0.0 && !plant.method.bounces() {
            let rule = "0, for this method stops what lands somewhere within a step: take one that finds landings, as MidpointContact, or \
                        SemiImplicitEuler";
            return Err(PlantError::value(
                format!("plant.restitution of the method {:?}", plant.method),
                plant.restitution,
                rule,
            ));
        }
        if plant.restitution > 0.0 && law == Law::SpringDamper {
            let rule = "0, because the springs of this law bounce by themselves: lower plant.contact_damping_ratio";
            return Err(PlantError::value("plant.restitution of the law SpringDamper", plant.restitution, rule));
        }
        Ok(Settings {
            h: plant.dt,
            steps_per_period: ((1.0 / rate / plant.dt).round() as u64).max(1),
            law: plant.law,
            tolerance: plant.tolerance,
            method: plant.method,
            friction: plant.friction,
            restitution: plant.restitution,
            spring: ContactSpring {
                stiffness: plant.contact_stiffness,
                damping_ratio: plant.contact_damping_ratio,
                h: plant.dt,
            },
            standing_feet: true,
            tolerance_step: plant.tolerance_step,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The verdict on a report, in the world of a scene.
    fn judged(law: Law, restitution: f64, energy_gain: f64, work: f64) -> Result<(), PlantError> {
        let mut scene = Scene::default();
        (scene.plant.law, scene.plant.restitution) = (law, restitution);
        let world = World::new(&scene).unwrap_or_else(|error| panic!("{error}"));
        world.check_energy(&Report { energy_gain, work, own: 3e-11, ..Report::default() })
    }

    #[test]
    fn an_energy_gain_beyond_rounding_ends_the_run() {
        for law in [Law::Cone, Law::Aligned, Law::EnergyQp, Law::ConeQp] {
            for work in [1e-9, 1.0, 1e6] {
                let least = ENERGY_GAIN * work;
                for gain in [-work, 0.0, least] {
                    assert_eq!(judged(law, 0.0, gain, work), Ok(()), "{law}, {gain:e} of {work:e}");
                }
                for gain in [least.next_up(), 2.0 * least, work] {
                    let error = PlantError::GainsEnergy { time: 0.0, law, gain, residual: 3e-11 };
                    assert_eq!(judged(law, 0.0, gain, work), Err(error), "{law}, {gain:e} of {work:e}");
                }
            }
        }
    }

    #[test]
    fn springs_may_raise_the_energy_and_bounces_may_not() {
        for law in [Law::SpringDamper, Law::Sweep(3)] {
            assert_eq!(judged(law, 0.0, 1.0, 1.0), Ok(()), "{law}");
        }
        assert!(judged(Law::Cone, 0.5, 1.0, 1.0).is_err());
    }
}
