//! Claims about the contact laws, compared with closed-form solutions of a sliding point.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{run, scene};
use messages::robot::Body;
use messages::scene::{Initial, Iteration, Law, Scene};
use messages::wire::Torques;
use plant::Plant;
use plant::kinematics::{self, Pose};

const G: f64 = 9.81;
const MU: f64 = 0.5;
const H: f64 = 1e-3;
/// The integration method of the paper, which the closed forms of single steps assume.
const EULER: &str = "plant.method=SemiImplicitEuler";

/// Under the printed QP a slipping contact separates with v_N = μ |v_F|, so the cube jumps once and rises by 8.15 mm.
///
/// After the first step, v_F = (v - μ g h)/(1 + μ²). From then on the cube flies, and each step reduces its upward velocity by g h.
#[test]
fn the_printed_qp_throws_a_slider_off_the_ground() {
    let limit = (MU / (1.0 + MU * MU)).powi(2) / (2.0 * G);
    assert!((limit - 8.15e-3).abs() < 0.01e-3);
    for h in [1e-3, 5e-4, 1.25e-4] {
        let thrown = MU * (1.0 - MU * G * h) / (1.0 + MU * MU);
        let flight = (0..).map(|k| thrown - f64::from(k) * G * h).take_while(|v| *v > 0.0);
        let hop: f64 = flight.map(|v| v * h).sum();
        // One step in each control period, so that every step is recorded.
        let settings = [&format!("plant.dt={h}"), &format!("rate={}", 1.0 / h), "initial.velocity=[1.0, 0.0, 0.0]"];
        let seen = run("slide", &[&settings[..], &["plant.law=EnergyQp", EULER]].concat()).number("hop_max_m");
        println!("h = {h}: hop {:.5} mm, {:.5} mm by theory", 1e3 * seen, 1e3 * hop);
        assert!((seen - hop).abs() < 1e-9, "h = {h}: hop {seen} m, not {hop} m");
        assert!(h > 2e-4 || (seen / limit - 1.0).abs() < 0.01, "{seen} m does not tend to {limit} m");
    }
}

#[test]
fn the_papers_conditions_keep_a_slider_on_the_ground_and_stop_it_at_coulombs_distance() {
    for law in ["plant.law=Complementarity", "plant.law=Aligned"] {
        for (setting, v) in [("initial.velocity=[1.0, 0.0, 0.0]", 1.0), ("initial.velocity=[2.0, 0.0, 0.0]", 2.0_f64)] {
            let stop = v * v / (2.0 * MU * G);
            // An Euler step uses the velocity at its end, so the distance is v h/2 less than the integral.
            run("slide", &[setting, law, EULER]).assert_ranges(&[
                ("hop_max_m", -1.0..=1e-9),
                ("penetration_max_m", 0.0..=1e-9),
                ("distance_m", stop - v * H..=stop + 1e-9),
                ("lateral_max_m", 0.0..=1e-9),
                ("com_speed_end_mps", 0.0..=1e-12),
                ("slip_misalignment_max_deg", 0.0..=1e-6),
            ]);
        }
    }
}

/// Every step of every built-in scene with the default law.
#[test]
fn every_built_in_scene_obeys_the_round_cone_in_every_step() {
    let published = include_str!("../messages/scenes/hashes.txt");
    let names = published.lines().skip(1).filter_map(|line| line.split_whitespace().next());
    let default: Vec<_> = names.filter(|name| scene(name, &[]).plant.law == Law::DEFAULT).collect();
    assert!(default.len() > 30, "{default:?}");
    for settings in [&[][..], &["plant.payload_kg=3.0"], &["plant.friction=0.3"], &["plant.friction=0.15"]] {
        let scenes = if settings.is_empty() { &default[..] } else { &["walk"] };
        for name in scenes {
            let summary = run(name, settings);
            let [map, fallbacks] = ["natural_map_max", "fallbacks"].map(|key| summary.number(key));
            assert!(
                map <= 1e-10 && fallbacks == 0.0,
                "{name} {settings:?}: natural map {map:e}, {fallbacks} fallbacks"
            );
        }
    }
}

/// Each law, in scenes that are easy for all of them: a falling body stays on the ground, a standing body stands still.
#[test]
fn every_law_runs_from_a_scene() {
    for law in Law::ALL {
        let law_name = format!("plant.law={law}");
        let slide = run("slide", &[&law_name]).number("distance_m");
        assert!((slide - 2.0 * 2.0 / (2.0 * MU * G)).abs() < 2.5e-3, "{law}: slides {slide} m");
        run("drop", &[&law_name, EULER, "plant.dt=0.001", "rate=1000"])
            .assert_ranges(&[("com_speed_end_mps", 0.0..=2e-2), ("penetration_max_m", 0.0..=5e-3)]);
        let stands = run("stand0", &["duration=1.0", &law_name]);
        // Spring contact oscillates, and its load creeps.
        let still = if law == Law::SpringDamper { 0.1 } else { 1e-3 };
        assert!(stands.number("distance_m").abs() < still, "{law}: {} m", stands.number("distance_m"));
    }
}

/// On flat ground the feet hardly slide, so the robot walks under every law. The laws differ in their residuals. (The robot also walks under
/// the laws that are left out here because they are slow.)
#[test]
fn every_law_carries_the_walk() {
    let slow = [Law::Facets(16), Law::FixedPoint(Iteration::Tresca)];
    for law in Law::ALL.into_iter().filter(|law| !slow.contains(law)) {
        let walk = run("walk", &["duration=4.0", &format!("plant.law={law}")]);
        println!(
            "{law}: {:.4} m, {:+.4} m aside, natural map {:.0e}, {} fallbacks",
            walk.number("distance_m"),
            walk.number("lateral_max_m"),
            walk.number("natural_map_max"),
            walk.number("fallbacks")
        );
        assert!(!walk.fell() && walk.number("distance_m") > 0.2, "{law}");
    }
}

/// A point mass, so that no rotation affects the result.
fn point(law: Law, velocity: [f64; 3]) -> Plant {
    let body = Body { name: "point".into(), mass: 2.0, size: [0.1; 3], contacts: vec![[0.0; 3]], ..Body::default() };
    let mut scene = Scene {
        bodies: vec![body],
        initial: Initial { clearance: Some(0.0), velocity, ..Initial::default() },
        ..Scene::default()
    };
    (scene.plant.law, scene.plant.friction, scene.plant.dt) = (law, MU, H);
    Plant::new(&scene).expect("a point can be simulated")
}

/// KKT conditions of (14)-(16) for one slipping point: v_F = (v - μ g h)/(1 + μ²) and v_N = μ v_F; those of
/// (17)-(22): v_F = v - μ g h and v_N = 0. The tolerance 1e-10 is that of a solved step.
#[test]
fn one_step_of_a_point_matches_the_multipliers() {
    for v in [0.1, 1.0, 3.0] {
        for law in [Law::EnergyQp, Law::EnergyQpGap, Law::Complementarity, Law::Aligned] {
            let mut plant = point(law, [v, 0.0, 0.0]);
            plant.step().expect("one step");
            let (v_f, v_n) = (plant.state().xdot[0], plant.state().xdot[2]);
            let slip = v - MU * G * H;
            let (want_f, want_n) = match law {
                Law::EnergyQp | Law::EnergyQpGap => (slip / (1.0 + MU * MU), MU * slip / (1.0 + MU * MU)),
                _ => (slip, 0.0),
            };
            assert!((v_f - want_f).abs() < 1e-10 && (v_n - want_n).abs() < 1e-10, "{law:?}: {v_f} {v_n} from {v}");
        }
    }
}

/// On a slope below the friction angle the point sticks, also under a push across the slope. A law that resists one tangent only would let
/// it creep along the other.
#[test]
fn the_default_law_and_aligned_resist_both_tangents() {
    let creep = |law: &str| {
        let settings = [law, "plant.incline_deg=10", "initial.velocity=[0.0, 0.0, 0.0]"];
        let summary = run("slide", &settings);
        summary.assert_ranges(&[("fallbacks", 0.0..=0.0)]);
        summary.number("distance_m").hypot(summary.number("lateral_max_m"))
    };
    for law in ["plant.law=Cone", "plant.law=Aligned"] {
        let displacement = creep(law);
        println!("{law}: {displacement:.1e} m in 1 s");
        assert!(displacement < 1e-9, "{law}: {displacement} m in 1 s");
    }
    // Above the friction angle it slides: tan 30 deg > 0.5.
    let slide = run("slide", &["plant.incline_deg=30", "initial.velocity=[0.0, 0.0, 0.0]"]).number("distance_m");
    let angle = 30f64.to_radians();
    let fall = 0.5 * G * (angle.sin() - MU * angle.cos());
    assert!((slide - fall).abs() < G * H, "{slide} m, {fall} m by theory");
}

/// The paper's single slip direction does not resist motion across it. So the feet on the ground creep while a robot steps on the spot.
/// With resistance in both tangents, they do not.
#[test]
fn one_slip_direction_lets_a_robot_that_steps_on_the_spot_drift() {
    for ground in ["plant.incline_deg=0", "plant.incline_deg=3", "plant.incline_deg=-3", "plant.friction=0.4"] {
        let displacement = |law: &str| run("stamp", &["duration=60", law, ground]).number("distance_m").abs();
        let [one, both, cone] = ["plant.law=Complementarity", "plant.law=Aligned", "plant.law=Cone"].map(displacement);
        println!("{ground}: {one} m with one slip direction, {both} m with both, {cone} m with the cone");
        assert!(one > 10.0 * both.max(cone), "{ground}: {one} m with one direction, {both} and {cone} m with both");
    }
}

#[test]
fn a_flat_drop_does_not_move_sideways() {
    let mut plant = Plant::new(&scene("drop", &[])).expect("the scene drop");
    let mut pose = Pose::new(plant.model());
    let (mut landed, mut end) = (false, [f64::NAN; 2]);
    for period in 0..1000 {
        plant.advance(&Torques::default()).expect("a step");
        kinematics::pose(plant.model(), plant.state(), &mut pose);
        let heights = plant.model().contact_points.iter().map(|corner| pose.point(corner.link, &corner.at).z);
        end = heights.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], z| [low.min(z), high.max(z)]);
        landed |= end[0] < 1e-9;
        if landed {
            let rise = plant.state().xdot[2];
            assert!(rise < 1e-9 && end[1] < 1e-9, "after {period} ms: {end:?} m, rising at {rise} m/s");
        }
    }
    assert!(landed && end[0].abs() < 1e-9 && end[1].abs() < 1e-9, "it ends with its corners at {end:?} m");
}
