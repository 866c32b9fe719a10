//! Claims about user-defined scenes: other bodies, other bases, no controller.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{RunSummary, fresh_path, run, run_smallest, run_two};
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

/// A scene file that is removed when dropped.
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

/// Largest deviation of the energy from its first value over 2 s, and largest kinetic energy [J].
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
fn a_frictionless_double_pendulum_keeps_its_energy_to_second_order_in_the_step() {
    let errors = [1e-3, 5e-4, 2.5e-4].map(energy_error);
    println!("energy errors {errors:?} J");
    for pair in errors.windows(2) {
        let order = pair[0][0] / pair[1][0];
        assert!((3.9..4.1).contains(&order), "halving the step divides the error by {order}: {errors:?}");
    }
    let [error, kinetic] = errors[2];
    assert!(kinetic > 1.0 && error < 1e-6 * kinetic, "{error} J of {kinetic} J: it must swing and keep its energy");
}

#[test]
fn a_users_own_pendulum_runs_in_one_process_and_in_two() {
    let file = File::new(PENDULUM);
    let [one, two] = [run(&file.0, &[]), run_two(&file.0, &[])];
    assert_eq!(one.hash(), two.hash());
    one.assert_ranges(&[("duration_s", 2.0..=2.0), ("steps", 0.0..=0.0), ("peak_torque_nm", 0.0..=0.0)]);
}

/// On a slope of 20° with friction .2 the box accelerates at g (sin - μ cos) with every type of base.
#[test]
fn a_box_slides_identically_with_every_type_of_base_that_can_slide() {
    let file = File::new(BOX);
    let angle = 20f64.to_radians();
    let way = 0.5 * 9.81 * (angle.sin() - 0.2 * angle.cos());
    let slide = |base: &str| -> RunSummary {
        let summary = run(&file.0, &[&format!("plant.base={base}")]);
        summary.assert_ranges(&[
            ("distance_m", way - 1e-9..=way + 1e-9),
            ("hop_max_m", -1.0..=1e-9),
            ("lateral_max_m", 0.0..=1e-9),
        ]);
        summary
    };
    let ways = ["planar", "virtual", "quaternion"].map(|base| slide(base).number("distance_m"));
    println!("{ways:?} m, {way} m by theory");
    assert!(ways.iter().all(|other| (other - ways[0]).abs() < 1e-9), "{ways:?}");
    // With friction above the slope it sticks.
    run(&file.0, &["plant.friction=0.4"]).assert_ranges(&[("distance_m", -1e-9..=1e-9)]);
}

/// The default is the scene's own model, and the summary of every run states its size.
#[test]
fn the_summary_states_the_size_of_the_model() {
    for way in [&["--in-process"][..], &["--full"], &[]] {
        let output = Command::new(env!("CARGO_BIN_EXE_biped"))
            .args(["run", "slide", "--quiet"])
            .args(way)
            .output()
            .expect("the program starts");
        let text = String::from_utf8_lossy(&output.stdout).into_owned();
        let model = "quaternion base, 6 degrees of freedom, 4 contact points, 2 friction directions per contact";
        assert!(output.status.success() && text.contains(model), "{way:?}: {text}");
    }
    let planar = run("slide", &["plant.base=planar"]);
    planar
        .assert_text("model", "planar base, 3 degrees of freedom, 4 contact points, 1 friction direction per contact");
    planar.assert_ranges(&[("model_cost_ratio", 1.0..=1.0)]);
}

/// The smallest model is simulated only with `--smallest`. It gives the same result with fewer coordinates.
#[test]
fn the_smallest_model_runs_only_on_request() {
    let [small, full] = [run_smallest("slide", &[]), run("slide", &[])];
    let own = "quaternion base, 6 degrees of freedom, 4 contact points, 2 friction directions per contact";
    full.assert_text("model", own);
    let ours = "planar base, 3 degrees of freedom, 2 contact points, 1 friction direction per contact";
    small.assert_text("model", &format!("{ours}; in full: {own}"));
    let ratio = small.number("model_cost_ratio");
    assert!(ratio.is_finite() && ratio > 0.0 && ratio != 1.0, "the ratio is measured: {ratio}");
    let ways = [&small, &full].map(|summary| summary.number("distance_m"));
    assert!((ways[0] - ways[1]).abs() < 1e-12, "{ways:?}");
    assert_ne!(small.hash(), full.hash(), "they are different models");
    let [small, full] = [run_smallest("stand", &["duration=0.1"]), run("stand", &["duration=0.1"])];
    assert_eq!(small.hash(), full.hash(), "a scene with a controller keeps its model");
    small.assert_ranges(&[("model_cost_ratio", 1.0..=1.0)]);
    let output =
        Command::new(env!("CARGO_BIN_EXE_biped")).args(["model", "slide"]).output().expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout).into_owned();
    assert!(
        output.status.success() && [own, ours, "of the computing time"].iter().all(|part| text.contains(part)),
        "{text}"
    );
}

/// Runs a scene in one process. Returns the rows of its trajectory table, with the columns whose names begin with one of the given words.
fn columns(scene: &str, settings: &[&str], beginnings: &[&str]) -> Vec<Vec<f64>> {
    let folder = fresh_path("table");
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--quiet", "--in-process", "--out"])
        .arg(&folder)
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{scene}: {output:?}");
    let text = std::fs::read_to_string(folder.join("trajectory.csv")).expect("a table");
    std::fs::remove_dir_all(folder).expect("our own folder");
    let mut lines = text.lines().skip_while(|line| line.starts_with('#'));
    let names: Vec<_> = lines.next().expect("names").split(',').collect();
    let wanted = |i: &usize| beginnings.iter().any(|beginning| names[*i].starts_with(beginning));
    let wanted: Vec<_> = (0..names.len()).filter(wanted).collect();
    let row = |line: &str| -> Vec<f64> {
        let cells: Vec<_> = line.split(',').collect();
        wanted.iter().map(|&i| cells[i].parse().unwrap_or(f64::NAN)).collect()
    };
    lines.map(row).collect()
}

/// In a mirror-symmetric scene, the loads on all contact points and the zero-moment point are symmetric.
#[test]
fn a_symmetric_scene_shows_symmetric_loads() {
    // pairs of mirrored contact points
    let pairs = [(0, 1), (2, 3)];
    for (name, weight) in [("slide", 9.81), ("stick", 9.81), ("incline", 9.81), ("drop", 9.81)] {
        let rows = columns(name, &["duration=0.6"], &["zmp_y", "normal_"]);
        let mut worst = [0.0_f64; 2];
        for row in rows.iter().filter(|row| row[0].is_finite()) {
            worst[0] = worst[0].max(row[0].abs());
            worst[1] = pairs.iter().fold(worst[1], |worst, (i, j)| worst.max((row[1 + i] - row[1 + j]).abs()));
        }
        let loaded = rows.iter().filter(|row| row[1..].iter().sum::<f64>() > 0.5 * weight).count();
        println!("{name}: zero-moment point off by {:.1e} m, loads by {:.1e} N in {loaded} rows", worst[0], worst[1]);
        assert!(loaded > 20 && worst[0] < 1e-9 && worst[1] < 1e-9 * weight, "{name}: {worst:?}, {loaded}");
    }
    let rows = columns("stand0", &["duration=0.6"], &["zmp_y", "normal_"]);
    let weight = rows[rows.len() - 1][1..].iter().sum::<f64>();
    assert!(weight > 100.0, "it stands: {weight} N");
    // eight contacts of two feet are solved to a residual; loading one edge only would be off by the whole weight
    let residual = 1e-8;
    for row in &rows[1..] {
        let feet = [&row[1..5], &row[5..9]].map(|foot| foot.iter().sum::<f64>());
        assert!(row[0].abs() < 1e-9 && (feet[0] - feet[1]).abs() < residual * weight, "{row:?}");
    }
}
