//! Claims about a user's own scenes: other bodies, other bases, no controller.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

mod common;

use common::{Summary, fresh_path, run, run_full, run_two};
use messages::load::load;
use messages::wire::Torques;
use plant::Plant;
use plant::kinematics::{self, Pose};
use std::process::Command;

const PENDULUM: &str = r#"
description = "A double pendulum, let go level."
duration = 2.0

[plant]
base = "fixed"
drive_inertia = 0.0

[initial]
joints = [1.2, 0.5]

[[bodies]]
name = "hook"
mass = 1.0
size = [0.1, 0.1, 0.1]

[[bodies]]
name = "upper arm"
mass = 1.0
size = [0.05, 0.05, 0.4]
com = [0.0, 0.0, -0.2]
joint = { parent = "hook", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }

[[bodies]]
name = "lower arm"
mass = 0.5
size = [0.05, 0.05, 0.4]
com = [0.0, 0.0, -0.2]
joint = { parent = "upper arm", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, -0.4] }
"#;

const BOX: &str = r#"
description = "A flat box on a slope."
duration = 1.0

[plant]
base = "planar"
incline_deg = 20.0
friction = 0.2

[initial]
clearance = 0.0

[[bodies]]
name = "box"
mass = 2.0
size = [0.4, 0.4, 0.1]
contacts = [[0.2, 0.0, -0.05], [-0.2, 0.0, -0.05]]
"#;

/// A file of the user's, gone when dropped.
struct File(String);

impl File {
    fn new(text: &str) -> File {
        let path = fresh_path("scene.toml").to_string_lossy().into_owned();
        std::fs::write(&path, text).expect("a file");
        File(path)
    }
}

impl Drop for File {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.0);
    }
}

/// Greatest departure of the energy from its first value over 2 s, after the start [J], and the greatest kinetic one.
fn energy_error(dt: f64) -> [f64; 2] {
    let file = File::new(PENDULUM);
    let scene = load(&file.0, &[format!("plant.dt={dt}")], &[]).expect("a good scene");
    let mut plant = Plant::new(&scene).expect("a pendulum can be simulated");
    let mut pose = Pose::new(plant.model());
    let mut energy = |plant: &Plant| {
        kinematics::pose(plant.model(), plant.state(), &mut pose);
        let totals = kinematics::totals(plant.model(), plant.state(), &pose);
        [totals.kinetic + totals.potential, totals.kinetic]
    };
    let [start, _] = energy(&plant);
    let mut worst = [0.0_f64; 2];
    for _ in 0..2000 {
        plant.advance(&Torques::default()).expect("a step");
        let [total, kinetic] = energy(&plant);
        worst = [worst[0].max((total - start).abs()), worst[1].max(kinetic)];
    }
    worst
}

#[test]
fn a_frictionless_double_pendulum_keeps_its_energy_to_first_order_in_the_step() {
    let errors = [1e-3, 5e-4, 2.5e-4].map(energy_error);
    println!("energy errors {errors:?} J");
    for pair in errors.windows(2) {
        let order = pair[0][0] / pair[1][0];
        assert!((1.8..2.2).contains(&order), "halving the step divides the error by {order}: {errors:?}");
    }
    let [error, kinetic] = errors[2];
    assert!(kinetic > 1.0 && error < 0.01 * kinetic, "{error} J of {kinetic} J: it must swing and keep its energy");
}

#[test]
fn a_users_own_pendulum_runs_in_both_ways() {
    let file = File::new(PENDULUM);
    let [one, two] = [run(&file.0, &[]), run_two(&file.0, &[])];
    assert_eq!(one.hash(), two.hash());
    one.shows(&[("duration_s", 2.0..=2.0), ("steps", 0.0..=0.0), ("peak_torque_nm", 0.0..=0.0)]);
}

/// Down a slope of 20° with friction .2 it accelerates at g (sin - mu cos), whatever base carries it.
#[test]
fn a_box_slides_the_same_on_every_base_that_lets_it() {
    let file = File::new(BOX);
    let angle = 20f64.to_radians();
    let way = 0.5 * 9.81 * (angle.sin() - 0.2 * angle.cos());
    let slide = |base: &str| -> Summary {
        let summary = run_full(&file.0, &[&format!("plant.base={base}")]);
        // v h/2 more than the integral, with dt .5 ms
        summary.shows(&[("distance_m", way..=way + 1e-3), ("hop_max_m", -1.0..=1e-9), ("lateral_max_m", 0.0..=1e-9)]);
        summary
    };
    let ways = ["planar", "virtual", "quaternion"].map(|base| slide(base).number("distance_m"));
    println!("{ways:?} m, {way} m by theory");
    assert!(ways.iter().all(|other| (other - ways[0]).abs() < 1e-9), "{ways:?}");
    // With more friction than slope it stays.
    run(&file.0, &["plant.friction=0.4"]).shows(&[("distance_m", -1e-9..=1e-9)]);
}

/// What a run prints about its model.
fn model(arguments: &[&str]) -> String {
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", "slide", "--quiet", "--set", "duration=5"])
        .args(arguments)
        .output()
        .expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    let line = text.lines().find(|line| line.trim_start().starts_with("model")).map(str::to_string);
    line.unwrap_or_else(|| panic!("{arguments:?}: no line about the model: {output:?}"))
}

#[test]
fn a_run_picks_the_smallest_model_says_so_and_lets_itself_be_told_otherwise() {
    for way in [&["--in-process"][..], &[]] {
        let picked = model(way);
        assert!(
            picked.contains("planar base, 3 degrees") && picked.contains("in full: quaternion base, 6"),
            "{picked}"
        );
        let full = model(&[way, &["--full"]].concat());
        assert!(full.contains("quaternion base, 6") && !full.contains("planar"), "{full}");
    }
    let [small, full] = [run("slide", &[]), run_full("slide", &[])];
    let ways = [&small, &full].map(|summary| summary.number("distance_m"));
    assert!((ways[0] - ways[1]).abs() < 1e-12, "{ways:?}");
    assert_ne!(small.hash(), full.hash(), "they are different models");
}
