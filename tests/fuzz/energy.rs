//! That what nothing drives only loses energy: of seeds by the tests, of all that a fuzzer makes of them by its harness.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::kinematics::{self, Pose};
use plant::{Plant, PlantError};

/// Runs that many periods of a scene in which nothing gives energy back, and compares the energy of each with the one before: `most` may be
/// made, as a part of the greatest that there was.
///
/// # Errors
/// As the plant.
///
/// # Panics
/// If it has risen, unless the scene began inside the ground, which lifts it out.
pub fn check(scene: &Scene, periods: usize, most: f64) -> Result<(), PlantError> {
    let mut plant = Plant::new(scene)?;
    let is_lifted = plant.truth().penetration > 0.0;
    let (mut before, mut scale) = energy(&plant);
    for period in 0..periods {
        plant.advance(&Torques::default())?;
        let (now, size) = energy(&plant);
        scale = scale.max(size);
        let made = now - before;
        assert!(made <= most * scale || is_lifted, "{made:e} J of {scale:e} J are made in period {period}");
        before = now;
    }
    Ok(())
}

/// Kinetic energy and that in the field of gravity [J], and the greatest part of it that was ever looked at.
fn energy(plant: &Plant) -> (f64, f64) {
    let mut pose = Pose::new(plant.model());
    kinematics::pose(plant.model(), plant.state(), &mut pose);
    let totals = kinematics::totals(plant.model(), plant.state(), &pose);
    let height = -totals.mass * plant.model().gravity.dot(&totals.com);
    (totals.kinetic + height, totals.kinetic + height.abs())
}
