//! Claims about extrema.

use crate::analysis::synthetic::SyntheticWalk;
use crate::analysis::{RunAnalysis, TIME_AFTER_FALL};
use messages::scene::{ControllerScene, GroundTile, Scene};
use messages::wire::Truth;

#[test]
fn a_fall_is_detected_at_its_time_and_ends_step_detection() {
    let (walk, mut analysis) = (SyntheticWalk::new(0.06), RunAnalysis::new(&Scene::default()));
    for seq in 0..6000 {
        let time = seq as f64 * 1e-3;
        let mut truth = walk.truth(seq, time);
        // Tips over backwards about the ground from 4 s on, at 1 rad/s.
        let tilt = (time - 4.0).max(0.0);
        truth.base_orientation = [(tilt / 2.0).cos(), 0.0, -(tilt / 2.0).sin(), 0.0];
        analysis.push(&truth);
    }
    let fall = analysis.extrema.fall.expect("45 degrees is a fall");
    assert!((fall - 4.0 - 45f64.to_radians()).abs() < 2e-3, "{fall}");
    assert!(analysis.gait.steps.iter().all(|step| step.start < fall));
    assert_eq!(analysis.time_of_completed_fall(), Some(fall));
    let last = analysis.last.expect("a last record").derived.time;
    assert!((last - fall - TIME_AFTER_FALL).abs() < 2e-3, "the record ends at {last} s");
}

/// The robot of Table 1 upright with both soles at this height [m], its ankles and hips bent by an angle [rad].
fn crouch(bend: f64, sole: f64) -> Truth {
    let leg = [0.0, bend, -2.0 * bend, bend]; // equal shank and thigh of .2 m
    let angle = std::array::from_fn(|i| if i < 4 { leg[i] } else { -leg[7 - i] });
    // Above the hips: half the trunk, .15 m. Below the ankles: .1 m.
    let base_position = [0.0, 0.0, sole + 0.15 + 0.4 * bend.cos() + 0.1];
    Truth { base_position, base_orientation: [1.0, 0.0, 0.0, 0.0], angle, ..Truth::default() }
}

/// The analysis of records at 0, 1, 2 s, ...
fn analysis(scene: &Scene, records: &[Truth]) -> RunAnalysis {
    let mut analysis = RunAnalysis::new(scene);
    for (second, record) in (0..).zip(records) {
        let mut truth = *record;
        truth.stamp.sim_ns = second * 1_000_000_000;
        truth.contact_force[2] = 1.0;
        analysis.push(&truth);
    }
    analysis
}

const UPRIGHT: f64 = 0.76;
const COLLAPSED: f64 = 1.45;

#[test]
fn heights_for_fall_and_hop_are_above_the_ground_under_the_robot() {
    let tile = |x, height| GroundTile { x, y: [-9.0, 9.0], height };
    let mut scene = Scene::default();
    scene.plant.ground.tiles =
        vec![tile([-9.0, -1.0], -0.2), tile([-1.0, 1.0], 0.0), tile([1.0, 8.0], -0.6), tile([8.0, 9.0], 0.5)];
    let at = |x: f64, mut truth: Truth| {
        truth.base_position[0] = x;
        truth
    };
    let down = [at(-5.0, crouch(UPRIGHT, -0.2)), at(0.0, crouch(UPRIGHT, 0.0)), at(5.0, crouch(UPRIGHT, -0.6))];
    let upright = analysis(&scene, &down);
    assert_eq!(upright.extrema.fall, None);
    assert!(upright.extrema.hop.abs() < 1e-12, "{}", upright.extrema.hop);
    let jump = analysis(&scene, &[down[0], at(5.0, crouch(COLLAPSED, -0.3))]);
    assert_eq!(jump.extrema.fall, None, "legs drawn up in the air are no fall");
    assert!((jump.extrema.hop - 0.3).abs() < 1e-12, "{}", jump.extrema.hop);
    let astride = analysis(&scene, &[down[1], at(1.0, crouch(UPRIGHT, 0.0))]);
    assert_eq!(astride.extrema.fall, None, "the heels on the edge of a step");
    let inside = analysis(&scene, &[down[0], at(7.95, crouch(UPRIGHT, -0.6))]);
    assert_eq!(inside.extrema.fall, None, "the toes in the side of a wall");
    for (x, height) in [(-5.0, -0.2), (0.0, 0.0), (5.0, -0.6), (1.0, 0.0)] {
        let collapsed = analysis(&scene, &[down[0], at(x, crouch(COLLAPSED, height))]);
        assert_eq!(collapsed.extrema.fall, Some(1.0), "at {x} m");
    }
}

#[test]
fn a_posture_as_low_as_commanded_is_no_fall() {
    let fall = |com_height: Option<f64>| {
        let controller = com_height.map(|com_height| ControllerScene { com_height, ..ControllerScene::default() });
        let scene = Scene { controller, ..Scene::default() };
        analysis(&scene, &[crouch(UPRIGHT, 0.0), crouch(COLLAPSED, 0.0)]).extrema.fall
    };
    assert_eq!([None, Some(0.27), Some(0.3)].map(fall), [Some(1.0); 3]);
    assert_eq!([Some(0.18), Some(0.15)].map(fall), [None; 2]);
}

#[test]
fn tilt_of_the_loaded_foot_and_margin_of_the_zero_moment_point_are_exact() {
    let (walk, scene) = (SyntheticWalk::new(0.06), Scene::default());
    // In single support on the right foot, the zero-moment point up to 0.3 of the half width off the centre.
    let mut analysis = RunAnalysis::new(&scene);
    (4000..6000).for_each(|seq| analysis.push(&walk.truth(seq, seq as f64 * 1e-3)));
    let landed: Vec<bool> = analysis.rows.iter().map(|row| row.has_landed).collect();
    assert!(!landed[..8].contains(&true) && landed.contains(&true), "{landed:?}"); // the first 35 ms, every 5 ms
    assert!((analysis.extrema.zmp_margin - 0.05 * 0.7).abs() < 1e-5, "{}", analysis.extrema.zmp_margin);
    assert!((analysis.rows[0].derived.load - 14.0 * 9.81).abs() < 1e-9);
    assert!(analysis.extrema.foot_tilt < 1e-12);
    let mut tilted = walk.truth(6000, 6.0);
    let (loaded, free) = if tilted.telemetry.support == 0 { (0, 7) } else { (7, 0) };
    tilted.angle[free] += 0.2;
    analysis.push(&tilted);
    assert!(analysis.extrema.foot_tilt < 1e-12, "a foot in the air may tilt");
    tilted.angle[loaded] += 0.01;
    analysis.push(&tilted);
    assert!((analysis.extrema.foot_tilt - 0.01).abs() < 1e-12, "{}", analysis.extrema.foot_tilt);
}

/// With few records, or steps without double support, the load passes from all of one foot to all of the other between two records.
#[test]
fn each_foot_has_its_time_to_land_although_support_passes_between_two_records() {
    let mut analysis = RunAnalysis::new(&Scene::default());
    let foot_of = |k: usize, analysis: &RunAnalysis| analysis.robot.feet.as_ref().expect("feet")[k].body;
    let bodies = [0, 1].map(|k| foot_of(k, &analysis));
    for tick in 0..200_u64 {
        // the left foot until 100 ms, on all corners; then the right one, for 30 ms on one corner
        let foot = usize::from(tick >= 100);
        let mut truth = crouch(UPRIGHT, 0.0);
        truth.stamp.sim_ns = tick * 1_000_000;
        let own = analysis.robot.contacts.iter().enumerate().filter(|(_, (body, _))| *body == bodies[foot]);
        let corners: Vec<usize> = own.map(|(i, _)| i).take(if (100..130).contains(&tick) { 1 } else { 4 }).collect();
        corners.iter().for_each(|i| truth.contact_force[3 * i + 2] = 10.0);
        analysis.push(&truth);
    }
    assert!((analysis.extrema.zmp_margin - 0.05).abs() < 1e-12, "{}", analysis.extrema.zmp_margin);
}

#[test]
fn a_point_over_a_gap_of_the_ground_has_no_height() {
    let mut scene = Scene::default();
    let left = scene.bodies.iter().position(|body| body.name == messages::robot::LEFT_FOOT).expect("a foot");
    scene.bodies[left].tiles = Some(messages::robot::Tiles { first: 0.0, pitch: 10.0, length: 1.0 });
    let at = |x: f64, right_knee: f64| {
        let mut truth = crouch(UPRIGHT, 0.0);
        truth.base_position[0] = x;
        truth.angle[5] += right_knee;
        truth
    };
    let over_gap = analysis(&scene, &[at(0.0, 0.0), at(5.0, 0.5)]).extrema.hop;
    let over_ground = analysis(&scene, &[at(0.0, 0.0), at(10.0, 0.5)]).extrema.hop;
    assert!(over_gap > 0.02 && over_ground.abs() < 1e-9, "{over_gap} m, {over_ground} m");
}

#[test]
fn a_nan_residual_stays_visible() {
    let mut analysis = RunAnalysis::new(&Scene::default());
    let walk = SyntheticWalk::new(0.0);
    for seq in 0..3 {
        let truth = walk.truth(seq, seq as f64 * 1e-3);
        analysis.push(&Truth { signorini: if seq == 1 { f64::NAN } else { 1e-16 }, ..truth });
    }
    assert!(analysis.extrema.signorini.is_nan() && analysis.extrema.natural_map > 0.0);
}
