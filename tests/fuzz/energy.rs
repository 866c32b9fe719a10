//! The claim that a passive scene gains no energy but for the error of its steps, and that the summary reports what it gains. The tests
//! check it for the stored inputs, and the fuzzer for every input that it generates.

use messages::scene::Scene;
use messages::wire::Torques;
use plant::kinematics::{self, Pose};
use plant::{Plant, PlantError};
use records::analysis::RunAnalysis;

/// A difference between plant and records up to this part of the largest energy is rounding [-].
const REPORTED: f64 = 1e-9;

/// Runs a number of control periods of a passive scene, as long as `goes_on`. In each, the energy may rise by `most`, relative to the
/// largest energy so far, by the error of its steps, and by the work of a ground that pushes a body out. The error of a step of second
/// order has terms of third order, ω³h³ and ω|Δω|h². The work is the force times the depth of the body.
///
/// # Errors
/// An error of the plant.
///
/// # Panics
/// If the energy rises by more, or by more than the summary of the run reports.
pub fn check(scene: &Scene, periods: usize, most: f64, goes_on: impl Fn() -> bool) -> Result<(), PlantError> {
    let mut plant = Plant::new(scene)?;
    let mut analysis = RunAnalysis::without_rows(scene);
    analysis.push(&plant.truth());
    let steps = (1.0 / (scene.rate * scene.plant.dt)).max(1.0);
    let (mut before, mut scale) = energy(&plant);
    for period in (0..periods).take_while(|_| goes_on()) {
        let (depth, spin) = (plant.truth().penetration, angular_speed(&plant));
        plant.advance(&Torques::default())?;
        let truth = plant.truth();
        analysis.push(&truth);
        let (now, size) = energy(&plant);
        scale = scale.max(size);
        let [turn, bend] =
            [spin.max(angular_speed(&plant)), (angular_speed(&plant) - spin).abs()].map(|rate| rate * scene.plant.dt);
        let load: f64 = truth.contact_force.iter().skip(2).step_by(3).sum();
        let allowed = (most + steps * turn * (turn * turn + bend)) * scale + load * depth;
        let (made, reported) = (now - before, analysis.energy.made);
        assert!(
            made <= allowed,
            "the energy rises by {made:e} J of {scale:e} J in period {period}, {allowed:e} J are allowed"
        );
        assert!(made <= reported + REPORTED * scale, "the energy rises by {made:e} J, {reported:e} J are reported");
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

/// Angular speed of the body that turns fastest [rad/s].
fn angular_speed(plant: &Plant) -> f64 {
    let mut pose = Pose::new(plant.model());
    kinematics::pose(plant.model(), plant.state(), &mut pose);
    pose.links.iter().map(|link| link.velocity.angular.norm()).fold(0.0, f64::max)
}
