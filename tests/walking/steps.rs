//! Claims about the steps that a summary counts.

use crate::common::run;

/// The controller counts its own exchanges. A robot that cannot sway, one that drags its feet, and one whose feet bounce, because commands
/// are late or the ground is rough, take them without a tidy lift or a centre of mass that crosses the midline.
#[test]
fn the_steps_of_the_summary_are_those_of_the_controller_however_untidy_they_are() {
    run("walk", &["plant.base=planar"]).assert_ranges(&[("steps", 53.0..=55.0), ("period_s", 0.46..=0.472)]);
    run("walk", &["controller.swing_height=0.001"])
        .assert_ranges(&[("steps", 41.0..=41.0), ("period_s", 0.594..=0.606)]);
    run("walk", &["link.delay_ms=5"]).assert_ranges(&[("steps", 40.0..=42.0), ("period_std_s", 0.0..=0.05)]);
    let rough = ["plant.ground.random.height=0.002", "plant.ground.random.size=[1e-6, 1e-6]"];
    run("walk", &rough).assert_ranges(&[("steps", 41.0..=43.0), ("period_s", 0.57..=0.61)]);
}

/// A payload at one side keeps the centre of mass there. Coarse encoders sway the robot after it has stopped, on both feet.
#[test]
fn steps_are_changes_of_the_support_foot_wherever_the_centre_of_mass_is() {
    let payload = ["plant.payload_kg=2", "plant.payload_offset=[0, 0.1, 0.1]"];
    run("walk", &payload).assert_ranges(&[("steps", 41.0..=41.0), ("period_s", 0.594..=0.606)]);
    let stop = ["plant.encoder_bits=15", "controller.stop_time=8", "duration=20"];
    run("walk", &stop).assert_ranges(&[
        ("steps", 20.0..=22.0),
        ("period_s", 0.594..=0.606),
        ("period_std_s", 0.0..=0.006),
    ]);
}
