//! Claims about programs that are not ours: controllers in Python keep the robot up as our own does, MuJoCo's robot walks
//! as ours does, what fails is named, other engines read the exported robot as the same equations of motion, and other
//! readers our recordings.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use common::{RobotFile, fresh_path, scene, shanks, similar};
use languages::python;
use messages::scene::Base;
use messages::session::Session;
use nalgebra::{UnitQuaternion, Vector3};
use plant::dynamics;
use plant::kinematics::{self, Pose};
use plant::model::Model;
use plant::state::State;
use serde_json::{Value, json};
use std::process::{Command, Output};

/// A run with a controller given by a command; also its summary, if it left one.
fn run(scene: &str, arguments: &[&str]) -> (Output, Value) {
    let folder = fresh_path("foreign");
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--quiet", "--out"])
        .arg(&folder)
        .args(arguments)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("OPENBLAS_NUM_THREADS", "1") // eight joints need no threads
        .output()
        .expect("the program starts");
    let summary = std::fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let _ = std::fs::remove_dir_all(folder);
    (output, serde_json::from_str(&summary).unwrap_or_default())
}

/// The same with one of the controllers in Python; it must end well.
fn run_python(scene: &str, controller: &str, settings: &[&str]) -> Value {
    let command = format!("{} controller/foreign/python/{controller}", python().display());
    let mut arguments = vec!["--controller", &command];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    let (output, summary) = run(scene, &arguments);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{controller}: {}: {errors}", output.status);
    summary
}

fn number(summary: &Value, key: &str) -> f64 {
    summary[key].as_f64().unwrap_or_else(|| panic!("{key} in {summary}"))
}

#[test]
fn a_spring_and_a_damper_in_python_stand() {
    let summary = run_python("stand", "stand.py", &["duration=1"]);
    assert_eq!(summary["fell"], false);
    let distance = number(&summary, "distance_m");
    assert!(distance.abs() < 5e-3, "it stays where it is: {distance}");
}

#[test]
fn the_paper_in_numpy_walks_as_far_as_the_paper_in_rust() {
    let theirs = run_python("walk", "walk.py", &[]);
    let (_, ours) = run("walk", &[]);
    let (theirs, ours) = (number(&theirs, "distance_m"), number(&ours, "distance_m"));
    assert!(ours > 2.0 && (theirs / ours - 1.0).abs() < 0.01, "{theirs} m beside {ours} m");
}

#[test]
fn the_paper_in_numpy_goes_on_amid_the_step_in_which_it_died() {
    let script = fresh_path("dies.py");
    let once = fresh_path("dead");
    let text = format!(
        "import os, sys\nsys.path.insert(0, 'controller/foreign/python')\nimport session, walk\n\n\nclass Dies(walk.Walk):\n    \
         ticks = 0\n\n    def tick(self, counts, telemetry):\n        self.ticks += 1\n        if self.ticks == 2300 and not \
         os.path.exists({0:?}):\n            open({0:?}, 'w').close()\n            raise RuntimeError('amid a step')\n        \
         return super().tick(counts, telemetry)\n\n\nsession.serve(Dies)\n",
        once.display().to_string()
    );
    std::fs::write(&script, text).expect("a file");
    let command = format!("{} {}", python().display(), script.display());
    let (output, summary) = run("walk", &["--controller", &command, "--respawn", "1", "--set", "duration=4"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && errors.contains("starting it anew"), "{}: {errors}", output.status);
    let distance = number(&summary, "distance_m");
    assert!((0.2..0.3).contains(&distance), "{distance} m");
    [script, once].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn our_controller_walks_the_robot_of_mujoco_as_far_as_ours() {
    let session = format!("mujoco-{}", std::process::id());
    let command = format!("{} plant/foreign/mujoco/plant.py", python().display());
    let (output, theirs) = run("walk", &["--plant", &command, "--set", "duration=4", "--session", &session]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && theirs["fell"] == false, "{}: {errors}", output.status);
    let left = Session::named(&session).expect("a good name").leftovers();
    assert!(left.is_empty(), "{left:?}");
    let (_, ours) = run("walk", &["--set", "duration=4"]);
    for key in ["distance_m", "period_s", "peak_force_n"] {
        println!("{key}: {} beside {}", theirs[key], ours[key]);
    }
    let distance = (number(&theirs, "distance_m"), number(&ours, "distance_m"));
    assert!(distance.1 > 0.2 && (distance.0 / distance.1 - 1.0).abs() < 0.02, "{distance:?} m");
    assert_eq!(theirs["steps"], ours["steps"]);

    let (output, _) = run("walk", &["--plant", &command, "--set", "plant.push_impulse=[0,1,0]"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("the plant failed") && errors.contains("plant.push_impulse"), "{errors}");
}

#[test]
fn another_robot_is_walked_by_the_paper_in_numpy_and_by_mujoco_as_by_ours() {
    let robot = RobotFile::new(&shanks(1.2));
    let setting = robot.setting();
    let settings = ["duration=4", &setting];
    let (_, ours) = run("walk", &["--robot", robot.path(), "--set", settings[0]]);
    let numpy = run_python("walk", "walk.py", &settings);
    let mujoco = format!("{} plant/foreign/mujoco/plant.py", python().display());
    let (output, mujoco) = run("walk", &["--plant", &mujoco, "--set", settings[0], "--set", settings[1]]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let ours = number(&ours, "distance_m");
    for (theirs, share) in [(&numpy, 0.01), (&mujoco, 0.02)] {
        let theirs = number(theirs, "distance_m");
        assert!(ours > 0.2 && (theirs / ours - 1.0).abs() < share, "{theirs} m beside {ours} m");
    }
}

#[test]
fn a_foreign_controller_that_dies_or_never_answers_is_named_and_nothing_stays() {
    let crash = format!("{} -c \"raise ValueError('no legs')\"", python().display());
    let (output, _) = run("stand", &["--controller", &crash, "--respawn", "1"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{errors}");
    assert!(errors.contains("starting it anew"), "{errors}");
    assert!(errors.contains("the controller failed (exit status: 1)") && errors.contains("no legs"), "{errors}");

    let (output, _) = run("stand", &["--controller", "sh -c 'sleep 61.0625; true'", "--patience", "1"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(3), "{errors}");
    assert!(errors.contains("no controller answered"), "{errors}");
    let processes = std::fs::read_dir("/proc").expect("Linux").flatten();
    let lines = processes.filter_map(|process| std::fs::read_to_string(process.path().join("cmdline")).ok());
    assert!(!lines.into_iter().any(|line| line.starts_with("sleep\x0061.0625")), "a process was left behind");

    let other = "BIPED_CONTRACT=$(echo \"$BIPED_CONTRACT\" | sed s/lockstep/realtime/)";
    let other = format!("sh -c '{other} exec {} controller/foreign/python/stand.py'", python().display());
    let (output, _) = run("stand", &["--controller", &other]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(5), "{errors}");
    assert!(errors.contains("realtime"), "{errors}");
}

/// What `biped conform` finds in a program in Python: exit code, and all it says.
fn conform(role: &str, arguments: &str) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["conform", role, &format!("{} {arguments}", python().display())])
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .output()
        .expect("the program starts");
    let told = String::from_utf8_lossy(&output.stdout).into_owned() + &String::from_utf8_lossy(&output.stderr);
    (output.status.code(), told)
}

#[test]
fn ours_in_python_keep_the_rules_of_the_wire() {
    for controller in ["stand.py", "walk.py"] {
        let (code, told) = conform("--controller", &format!("controller/foreign/python/{controller}"));
        assert!(code == Some(0) && told.contains("32 rules kept"), "{controller}: {told}");
    }
    let (code, told) = conform("--plant", "plant/foreign/mujoco/plant.py");
    assert!(code == Some(0) && told.contains("37 rules kept") && told.contains("lockstep alone"), "{told}");
}

/// A piece of session.py, what takes its place, and what must be said of that.
type Flaw = [&'static str; 3];

#[test]
fn who_breaks_a_rule_is_told_which() {
    let programs: [&[Flaw]; 4] = [
        &[
            ["stamp.seq + 1, asked.seq,", "stamp.seq + 1, asked.seq - 1,", "ack is the number of the sensors answered"],
            ["sys.exit(INTERRUPTED))", "None)", "TERM ends it in order within 3 s: it was still there"],
        ],
        &[
            [
                "controller.tick(sensors.encoders.counts[:], answer.telemetry)",
                "[float('nan')] * 8",
                "torques are finite: torque[0]",
            ],
            ["if sensors.last:", "if False:", "`last` = 1 ends it in order within 3 s"],
            ["stamp.ack = asked.run, 0, 0", "stamp.ack = asked.run, 5, 0", "seq counts its messages of a run from 1"],
        ],
        &[
            [
                "sensors is None or not is_sound(sensors)",
                "sensors is None",
                "whose check sum is wrong are not answered",
            ],
            ["secrets.randbits(64)", "7", "it answers under another epoch"],
            ["                if stamp.run:\n", "                if False:\n", "takes a new run as a new robot"],
        ],
        &[
            ["sealed(message))", "message)", "every message is sealed"],
            ["fail(PEER_MISSING", "print(PEER_MISSING", "gives up without a plant"],
        ],
    ];
    let ours = std::path::Path::new("controller/foreign/python");
    let try_one = move |flaws: &[Flaw]| {
        let folder = fresh_path("flawed");
        std::fs::create_dir_all(&folder).expect("a folder");
        for file in ["stand.py", "wire.py"] {
            std::fs::copy(ours.join(file), folder.join(file)).expect("a copy");
        }
        let mut text = std::fs::read_to_string(ours.join("session.py")).expect("our own file");
        for [good, bad, _] in flaws {
            assert!(text.contains(good), "session.py has no longer {good}");
            text = text.replacen(good, bad, 1);
        }
        std::fs::write(folder.join("session.py"), text).expect("a file");
        let (code, told) = conform("--controller", &folder.join("stand.py").display().to_string());
        let broken = told.lines().filter(|line| line.starts_with("FAILED")).collect::<Vec<_>>().join("\n");
        for [_, bad, rule] in flaws {
            assert!(code == Some(10) && broken.contains(rule), "{bad}: {rule}: {told}");
        }
        std::fs::remove_dir_all(folder).expect("our own folder");
    };
    // most of their time is waiting for what must not come
    std::thread::scope(|scope| {
        for flaws in programs {
            scope.spawn(move || try_one(flaws));
        }
    });
}

/// H and b of random states, for the comparison.
fn states(scene: &messages::scene::Scene) -> Value {
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
        let mut pose = Pose::new(&model);
        kinematics::pose(&model, &state, &mut pose);
        let h = dynamics::inertia(&model, &pose);
        let b = dynamics::bias(&model, &pose, &state.xdot);
        let rows: Vec<Vec<f64>> = h.row_iter().map(|row| row.iter().copied().collect()).collect();
        json!({"x": state.x, "xdot": state.xdot, "H": rows, "b": b})
    });
    let states: Vec<Value> = states.collect();
    // by the order of the degrees of freedom, which need not be that of the wire
    let jointed = scene.bodies.iter().zip(&model.body_link).filter(|(body, _)| body.joint.is_some());
    let name = |name: &str| name.replace([' ', '-'], "_") + "_joint";
    let mut joints: Vec<(usize, String)> = jointed.map(|(body, &link)| (link, name(&body.name))).collect();
    joints.sort();
    let joints: Vec<String> = joints.into_iter().map(|(_, name)| name).collect();
    let free = model.base == Base::Quaternion;
    json!({"joints": joints, "gravity": model.gravity.as_slice(), "free": free, "states": states})
}

/// Greatest differences of H and b, each over its greatest entry, by engine. The export gets other settings than ours
/// where the test wants to see a difference.
fn differences(name: &str, settings: &[&str], exported: &[&str]) -> Value {
    let folder = fresh_path("export");
    std::fs::create_dir_all(&folder).expect("a folder");
    let mut files = vec![];
    for (format, file) in [("mjcf", "robot.xml"), ("urdf", "robot.urdf")] {
        let output = Command::new(env!("CARGO_BIN_EXE_biped"))
            .args(["export", format, &format!("launch/scenes/{name}.toml")])
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
fn mujoco_and_pinocchio_find_the_same_equations_of_motion_in_the_exported_robot() {
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
        [("walk", &free[..]), ("walk", &loaded), ("walk", &large), ("walk", &long), ("known/double-pendulum", &[])]
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
        assert!(number(&without, engine) > 1e-3, "negative control: {engine} must miss the drives, {without}");
    }
}

#[test]
fn a_recording_reads_as_its_own_schemas_and_foxglove_s_say() {
    let file = fresh_path("walk.mcap");
    let (output, summary) = run("walk", &["--record", &file.to_string_lossy(), "--set", "duration=4"]);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let output = Command::new(python()).arg("tests/foreign/recording.py").arg(&file).output().expect("Python");
    let words = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{words}");
    let seen: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    std::fs::remove_file(file).expect("our own file");
    let counts = ["/truth", "/sensors", "/command", "/telemetry", "/tf", "/forces", "/robot"]
        .map(|topic| seen["counts"][topic].as_u64().unwrap_or(0));
    assert_eq!(counts, [4001, 4001, 4000, 4000, 201, 201, 1], "{seen}");
    assert_eq!(seen["steps"], summary["steps"], "{summary}");
}
