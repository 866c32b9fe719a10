//! Other programs read the exported files: simulators compute the same equations of motion, and readers decode a recording by its own schemas.

use super::{number, run};
use crate::common::{RobotFile, fresh_path, scene, shanks, similar};
use crate::languages::python;
use messages::scene::{Base, Scene};
use nalgebra::{DMatrix, DVector, UnitQuaternion, Vector3};
use plant::dynamics;
use plant::kinematics::Pose;
use plant::model::Model;
use plant::state::State;
use serde_json::{Value, json};
use std::path::Path;
use std::process::Command;
use std::time::Instant;

/// H and b of random states, for the comparison.
fn states(scene: &Scene) -> Value {
    let model = Model::new(scene).expect("a good scene");
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut normal = || (0..12).map(|_| random.f64()).sum::<f64>() - 6.0;
    let states = (0..20).map(|_| {
        let mut state = State::zero(&model);
        state.x.iter_mut().for_each(|x| *x = normal());
        state.xdot.iter_mut().for_each(|v| *v = 2.0 * normal());
        if model.base == Base::Quaternion {
            let turn = UnitQuaternion::from_scaled_axis(Vector3::from_fn(|_, _| normal()));
            state.x[3..7].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
        }
        let pose = Pose::of(&model, &state);
        let h = dynamics::inertia(&model, &pose);
        let b = dynamics::bias(&model, &pose, &state.xdot);
        let (h, b) = in_the_frame_of_the_scene(&model, &pose, &mut state, [h, DMatrix::from_vec(b.len(), 1, b)]);
        let rows: Vec<Vec<f64>> = h.row_iter().map(|row| row.iter().copied().collect()).collect();
        json!({"x": state.x, "xdot": state.xdot, "H": rows, "b": b})
    });
    let states: Vec<Value> = states.collect();
    // in the order of the degrees of freedom, which can differ from wire order
    let jointed = scene.bodies.iter().zip(&model.body_link).filter(|(body, _)| body.joint.is_some());
    let name = |name: &str| name.replace([' ', '-'], "_") + "_joint";
    let mut joints: Vec<(usize, String)> = jointed.map(|(body, &link)| (link, name(&body.name))).collect();
    joints.sort();
    let joints: Vec<String> = joints.into_iter().map(|(_, name)| name).collect();
    let free = model.base == Base::Quaternion;
    json!({"joints": joints, "gravity": model.gravity.as_slice(), "free": free, "states": states})
}

/// H and b for the velocity of the frame that the scene gives the base. The model has it at the centre of mass, from which `r` points to the
/// frame: ẋ = S ẋ_s with ẋ_F = v_F + r × ω, so H_s = SᵀH S and b_s = Sᵀ(b + H Ṡ ẋ_s). Moves position and velocity of the state, too.
fn in_the_frame_of_the_scene(
    model: &Model,
    pose: &Pose,
    state: &mut State,
    [h, b]: [DMatrix<f64>; 2],
) -> (DMatrix<f64>, Vec<f64>) {
    if model.base != Base::Quaternion {
        return (h, b.as_slice().to_vec());
    }
    let r = pose.links[model.base_link].rotation * model.base_frame;
    let spin = Vector3::from_column_slice(&state.xdot[3..6]);
    let mut change = DMatrix::identity(h.nrows(), h.nrows());
    change.view_mut((0, 3), (3, 3)).copy_from(&r.cross_matrix());
    let mut acceleration = DVector::zeros(h.nrows());
    acceleration.rows_mut(0, 3).copy_from(&spin.cross(&r).cross(&spin));
    *state = state.in_scene_frame(model);
    let bias = change.transpose() * (b + &h * acceleration);
    (change.transpose() * h * &change, bias.as_slice().to_vec())
}

/// Largest differences of H and b relative to their largest entries, for each simulator. `exported` are the settings of the exported robot; they
/// differ from `settings` in the negative case.
fn differences(name: &str, settings: &[&str], exported: &[&str]) -> Value {
    let folder = fresh_path("export");
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut files = vec![];
    for (format, file) in [("mjcf", "robot.xml"), ("urdf", "robot.urdf")] {
        let output = Command::new(env!("CARGO_BIN_EXE_biped"))
            .args(["export", format, name])
            .args(exported.iter().flat_map(|setting| ["--set", setting]))
            .output()
            .expect("the program starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        files.push(folder.join(file));
        std::fs::write(folder.join(file), output.stdout).expect("a file");
    }
    files.push(folder.join("states.json"));
    std::fs::write(&files[2], states(&scene(name, settings)).to_string()).expect("a file");
    let output = Command::new(python()).arg("tests/foreign/dynamics.py").args(&files).output().expect("Python");
    assert!(output.status.success(), "{name}: {}", String::from_utf8_lossy(&output.stderr));
    std::fs::remove_dir_all(folder).expect("our own folder");
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn mujoco_and_pinocchio_compute_the_same_equations_of_motion_from_the_exported_robot() {
    let loaded = [
        "plant.base=quaternion",
        "plant.payload_kg=2",
        "plant.payload_offset=[0.03,0.02,0.1]",
        "plant.joint_damping=0.3",
        "plant.incline_deg=5",
        "bodies.trunk.com=[0.01,-0.02,0.03]",
    ];
    let free = ["plant.base=quaternion"];
    let files = [similar(1.5), shanks(1.2)].map(|robot| RobotFile::new(&robot));
    let [large, long] = files.each_ref().map(RobotFile::setting);
    let (large, long) = ([&*large, free[0]], [&*long, free[0]]);
    for (name, settings) in
        [("walk", &free[..]), ("walk", &loaded), ("walk", &large), ("walk", &long), ("double-pendulum", &[])]
    {
        let found = differences(name, settings, settings);
        println!("{name} {settings:?}: {found}");
        for engine in ["mujoco", "pinocchio"] {
            let difference = number(&found, engine);
            assert!(difference < 1e-12, "{name} {settings:?}: {engine} differs by {difference:e}");
        }
    }
    let without = differences("walk", &free, &["plant.drive_inertia=0"]);
    for engine in ["mujoco", "pinocchio"] {
        assert!(
            number(&without, engine) > 1e-3,
            "negative case: without drive inertia {engine} has to differ, {without}"
        );
    }
}

/// Position and velocity of the base belong to the frame that the scene gives it, also where that is not at its centre of mass.
#[test]
fn the_initial_state_of_an_exported_robot_is_that_of_the_scene() {
    let settings = ["initial.velocity=[0.1,0.2,0.3]", "initial.angular_velocity=[1,2,3]"];
    let ball = scene("ball", &settings);
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["export", "mjcf", "ball"])
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .output()
        .expect("the program starts");
    let text = String::from_utf8_lossy(&output.stdout);
    let key = text.lines().find(|line| line.contains("<key name=\"start\"")).expect("a keyframe");
    let first = |name: &str| -> Vec<f64> {
        let (_, values) = key.split_once(&format!("{name}=\"")).expect("values");
        values.split(['"', ' ']).take(3).map(|value| value.parse().expect("a number")).collect()
    };
    let truth = plant::Plant::new(&ball).expect("a plant").truth();
    assert!(ball.bodies[0].com != [0.0; 3]);
    for (found, expected) in [(first("qpos"), truth.base_position), (first("qvel"), ball.initial.velocity)] {
        let near = found.iter().zip(expected).all(|(found, expected)| (found - expected).abs() < 1e-12);
        assert!(near, "{found:?}, not {expected:?}");
    }
}

/// The contents of a recording, by the MCAP reader for Python.
fn read(file: &Path) -> Value {
    let output = Command::new(python()).arg("tests/foreign/recording.py").arg(file).output().expect("Python");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    serde_json::from_slice(&output.stdout).expect("JSON")
}

#[test]
fn a_recording_matches_its_own_schemas_and_those_of_foxglove() {
    let file = fresh_path("walk.mcap");
    let (output, summary) = run("walk", &["--record", &file.to_string_lossy(), "--set", "duration=4"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let seen = read(&file);
    std::fs::remove_file(file).expect("our own file");
    let counts = ["/truth", "/sensors", "/command", "/telemetry", "/tf", "/forces", "/robot"]
        .map(|topic| seen["counts"][topic].as_u64().unwrap_or(0));
    assert_eq!(counts, [4001, 4001, 4000, 4000, 201, 201, 1], "{seen}");
    assert_eq!(seen["steps"], summary["steps"], "{summary}");
    assert_eq!(seen["indexed"], seen["linear"], "{seen}");
    let begun = seen["begun"].as_str().expect("when it began");
    assert!(begun.starts_with("20") && begun.ends_with('Z') && begun.contains('T'), "{begun}");
}

#[test]
fn a_truncated_recording_opens_and_converts_into_a_complete_one() {
    for bytes in [1_000_000, 2_500_000, 4_000_000] {
        killed_at(bytes);
    }
}

fn killed_at(bytes: u64) {
    let [file, whole] = ["killed.mcap", "whole.mcap"].map(fresh_path);
    let mut walk = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args("run walk --in-process --quiet --set duration=1000 --record".split(' '))
        .arg(&file)
        .spawn()
        .expect("the program starts");
    let begun = Instant::now();
    while file.metadata().map_or(0, |about| about.len()) < bytes {
        assert!(begun.elapsed().as_secs() < 60, "nothing is recorded");
        std::thread::yield_now(); // so that the file often ends within a chunk
    }
    walk.kill().and_then(|()| walk.wait()).expect("our own child");
    let killed = read(&file);
    assert!(killed["linear"].as_u64() > Some(bytes / 2000) && killed["indexed"].is_null(), "{killed}");
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["convert".as_ref(), file.as_os_str(), "--mcap".as_ref(), whole.as_os_str()])
        .output()
        .expect("the program starts");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && printed.contains("is cut short"), "{printed}");
    let converted = read(&whole);
    assert_eq!(converted["indexed"], killed["linear"]);
    assert_eq!((&converted["counts"], &converted["x"]), (&killed["counts"], &killed["x"]));
    [file, whole].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

/// Runs the line of docs/WIRE.md.
#[test]
fn pandas_reads_a_recording_as_one_table() {
    let [file, table] = ["table.mcap", "table.csv"].map(fresh_path);
    let (_, summary) = run("walk", &["--record", &file.to_string_lossy(), "--set", "duration=2"]);
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["convert".as_ref(), file.as_os_str(), "--table".as_ref(), table.as_os_str()])
        .output()
        .expect("the program starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let text = std::fs::read_to_string("docs/WIRE.md").expect("a document");
    let line = text.lines().map(str::trim).find(|line| line.contains("pandas.read_csv(")).expect("the line");
    let script = format!(
        "import pandas\n{}\nprint(len(walk), walk.index[-1], '%016x' % walk['hash'].iloc[-1], walk['telemetry.steps'].iloc[-1])",
        line.replace("walk.csv", &table.to_string_lossy())
    );
    let output = Command::new(python()).args(["-c", &script]).output().expect("Python");
    let said = String::from_utf8_lossy(&output.stdout).trim().to_string();
    let hash = summary["trajectory_hash"].as_str().expect("a hash");
    assert_eq!(said, format!("2001 2.0 {hash} {}", summary["steps"]), "{}", String::from_utf8_lossy(&output.stderr));
    [file, table].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}
