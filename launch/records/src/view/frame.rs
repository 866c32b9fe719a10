//! Data for the page: frames of named numbers, and the constant description of the run.

use crate::analysis::{DerivedState, KinematicTree, LateralState, Peaks, RunAnalysis};
use base64::Engine;
use base64::prelude::BASE64_STANDARD;
use messages::scene::Scene;
use messages::wire::{PHASES, STATES, Truth};
use serde_json::{Value, json};

/// One frame: names and values of its quantities in SI units and world coordinates, or as in the wire message. The page
/// reads them in this order as 32-bit floats, which are precise enough for display.
pub fn frame(
    robot: &KinematicTree,
    truth: &Truth,
    derived: &DerivedState,
    peaks: &Peaks,
    fallen: bool,
) -> Vec<(&'static str, Vec<f64>)> {
    let joints = robot.joint_names().len().min(truth.angle.len());
    let lateral = LateralState::new(derived)
        .map_or([f64::NAN; 3], |lateral| [lateral.position, lateral.velocity, lateral.support as f64]);
    let soles = derived.soles.iter().flatten();
    let tally = &truth.tally;
    // before the first command there is no telemetry
    let planned = |energies: [f64; 2]| if truth.command.seq > 0 { energies.to_vec() } else { vec![f64::NAN; 2] };
    let forces = &truth.contact_force[..3 * robot.contacts.len()];
    let ground_force = [0, 1, 2].map(|axis| forces.iter().skip(axis).step_by(3).sum::<f64>());
    vec![
        ("time", vec![derived.time]),
        ("position", truth.base_position.to_vec()),
        ("orientation", truth.base_orientation.to_vec()),
        ("angle", truth.angle[..joints].to_vec()),
        ("com", derived.com.as_slice().to_vec()),
        ("velocity", derived.com_velocity.as_slice().to_vec()),
        ("zmp", derived.zmp.as_slice().to_vec()),
        (
            "soles",
            soles.flat_map(|sole| [sole.centre.x, sole.centre.y, sole.centre.z, sole.yaw(), sole.load]).collect(),
        ),
        ("lateral", lateral.to_vec()),
        ("force", forces.to_vec()),
        ("ground", ground_force.to_vec()),
        ("torque", peaks.torque[..joints].to_vec()),
        ("energy", planned(truth.telemetry.energy)),
        ("reference", planned(truth.telemetry.energy_ref)),
        ("residual", vec![peaks.natural_map, peaks.signorini]),
        ("age", vec![f64::from(peaks.age)]),
        ("reply", vec![peaks.reply_ns as f64 * 1e-6]),
        ("late", vec![peaks.late_ns as f64 * 1e-6]),
        ("phase", vec![f64::from(truth.telemetry.phase)]),
        ("support", vec![f64::from(truth.telemetry.support)]),
        ("steps", vec![truth.telemetry.steps as f64]),
        ("state", vec![f64::from(truth.state)]),
        ("refused", vec![tally.refused.iter().sum::<u64>() as f64]),
        ("lost", vec![tally.lost as f64]),
        ("fallen", vec![f64::from(fallen)]),
    ]
}

/// A frame as bytes for the page.
pub fn bytes(frame: &[(&'static str, Vec<f64>)]) -> impl Iterator<Item = u8> {
    frame.iter().flat_map(|(_, values)| values).flat_map(|value| (*value as f32).to_le_bytes())
}

/// Tiles are drawn up to this distance from the origin along x and y [m].
const DRAWN_GROUND: f64 = 20.0;

/// The constant description of a run: the robot, and the layout of a frame.
pub fn run_info(robot: &KinematicTree, scene: &Scene) -> Value {
    let truth = Truth { base_orientation: [1.0, 0.0, 0.0, 0.0], ..Truth::default() };
    let derived = DerivedState::new(robot, &truth, &robot.body_states(&truth));
    let layout: Vec<_> = frame(robot, &truth, &derived, &Peaks::default(), false)
        .into_iter()
        .map(|(name, values)| json!([name, values.len()]))
        .collect();
    let contacts: Vec<_> =
        robot.contacts.iter().map(|(body, ball)| json!({"body": body, "at": ball.at, "radius": ball.radius})).collect();
    let feet: Vec<_> =
        (robot.feet.iter().flatten()).map(|foot| json!({"body": foot.body, "half": foot.half})).collect();
    json!({
        "layout": layout,
        "bodies": robot.bodies,
        "contacts": contacts,
        "feet": feet,
        "trunk": robot.trunk,
        "joints": robot.joint_labels(),
        "phases": PHASES,
        "states": STATES,
        "tiles": scene.plant.ground.tiles_within(DRAWN_GROUND),
        "driven": scene.controller.is_some(),
        "duration": scene.duration,
        "period": 1.0 / scene.rate,
    })
}

/// All rows as frames in base 64.
pub fn trajectory(analysis: &RunAnalysis) -> String {
    let (rows, fall) = (analysis.rows.iter(), analysis.extrema.fall);
    let fallen = |time| fall.is_some_and(|fall| time >= fall);
    let bytes: Vec<u8> = rows
        .flat_map(|row| {
            bytes(&frame(&analysis.robot, &row.truth, &row.derived, &row.peaks, fallen(row.derived.time)))
                .collect::<Vec<_>>()
        })
        .collect();
    BASE64_STANDARD.encode(bytes)
}
