//! The claim that a passive scene never gains energy. The tests check it for the stored inputs, and the fuzzer for every input it generates.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::kinematics::{self, Pose};
use plant::{Plant, PlantError};

/// Runs a number of control periods of a passive scene, as long as `goes_on`. In each, the energy may rise by `most` at most, relative to
/// the largest energy so far.
///
/// # Errors
/// An error of the plant.
///
/// # Panics
/// If the energy rises by more, unless a body was inside the ground, which pushes it out: at the start, or in a tile that it entered from
/// the side.
pub fn check(scene: &Scene, periods: usize, most: f64, goes_on: impl Fn() -> bool) -> Result<(), PlantError> {
    let mut plant = Plant::new(scene)?;
    let mut was_inside = plant.truth().penetration > 0.0;
    let (mut before, mut scale) = energy(&plant);
    for period in (0..periods).take_while(|_| goes_on()) {
        plant.advance(&Torques::default())?;
        let (now, size) = energy(&plant);
        scale = scale.max(size);
        was_inside |= plant.model().ground.is_some() && plant.truth().penetration > 0.0;
        let made = now - before;
        assert!(made <= most * scale || was_inside, "the energy rises by {made:e} J of {scale:e} J in period {period}");
        before = now;
    }
    Ok(())
}

/// Kinetic plus potential energy [J], and the sum of their magnitudes [J].
fn energy(plant: &Plant) -> (f64, f64) {
    let mut pose = Pose::new(plant.model());
    kinematics::pose(plant.model(), plant.state(), &mut pose);
    let totals = kinematics::totals(plant.model(), plant.state(), &pose);
    let height = -totals.mass * plant.model().gravity.dot(&totals.com);
    (totals.kinetic + height, totals.kinetic + height.abs())
}
