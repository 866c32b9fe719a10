//! Controllers in Python and a plant in MuJoCo walk like the built-in ones.

use super::{number, run};
use crate::common::{RobotFile, fresh_path, shanks};
use crate::languages::{python, python_with_package};
use messages::session::Session;
use serde_json::Value;
use std::process::{Command, Output};

/// Runs a scene with a foreign program in a role, `--controller` or `--plant`.
fn run_foreign(scene: &str, role: &str, command: &str, settings: &[&str]) -> (Output, Value) {
    let mut arguments = vec![role, command];
    settings.iter().for_each(|setting| arguments.extend(["--set", setting]));
    run(scene, &arguments)
}

/// Runs a scene with one of the Python controllers. The run has to succeed.
fn run_python(scene: &str, controller: &str, settings: &[&str]) -> Value {
    let command = format!("{} controller/foreign/python/{controller}", python().display());
    let (output, summary) = run_foreign(scene, "--controller", &command, settings);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{controller}: {}: {errors}", output.status);
    summary
}

/// Runs the walk with MuJoCo as the plant; `options` are those of its program.
fn run_mujoco(options: &str, settings: &[&str]) -> (Output, Value) {
    let command = format!("{} plant/foreign/mujoco/plant.py {options}", python_with_package().display());
    run_foreign("walk", "--plant", &command, settings)
}

#[test]
fn the_standing_controller_in_python_stands() {
    let summary = run_python("stand", "stand.py", &["duration=1"]);
    assert_eq!(summary["fell"], false);
    let distance = number(&summary, "distance_m");
    assert!(distance.abs() < 5e-3, "it stays where it is: {distance}");
}

#[test]
fn the_controller_in_numpy_walks_as_far_as_the_one_in_rust() {
    for limit in ["40", "12"] {
        // The robot leans at 12 N·m.
        let limit = format!("plant.torque_limit={limit}");
        let theirs = run_python("walk", "walk.py", &[&limit]);
        let (_, ours) = run("walk", &["--set", &limit]);
        let (theirs, ours) = (number(&theirs, "distance_m"), number(&ours, "distance_m"));
        assert!(ours > 2.0 && (theirs / ours - 1.0).abs() < 0.01, "{limit}: {theirs} m beside {ours} m");
    }
}

#[test]
fn the_controller_in_numpy_continues_within_the_step_after_a_restart() {
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
    assert!(output.status.success() && errors.contains("restarting it"), "{}: {errors}", output.status);
    let distance = number(&summary, "distance_m");
    assert!((0.25..0.45).contains(&distance), "{distance} m");
    [script, once].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn the_controller_walks_as_far_in_mujoco_as_in_the_plant() {
    let session = format!("mujoco-{}", std::process::id());
    let command = format!("{} plant/foreign/mujoco/plant.py", python_with_package().display());
    let (output, theirs) = run("walk", &["--plant", &command, "--set", "duration=4", "--session", &session]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success() && theirs["fell"] == false, "{}: {errors}", output.status);
    let left = Session::named(&session).expect("a good name").shm_files();
    assert!(left.is_empty(), "{left:?}");
    let (_, ours) = run("walk", &["--set", "duration=4"]);
    for key in ["distance_m", "period_s", "peak_force_n"] {
        println!("{key}: {} beside {}", theirs[key], ours[key]);
    }
    let distance = (number(&theirs, "distance_m"), number(&ours, "distance_m"));
    assert!(distance.1 > 0.2 && (distance.0 / distance.1 - 1.0).abs() < 0.02, "{distance:?} m");
    assert_eq!(theirs["steps"], ours["steps"]);

    let (output, _) = run_mujoco("", &["plant.restitution=0.5"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(2), "{errors}");
    assert!(errors.contains("the plant failed") && errors.contains("plant.restitution"), "{errors}");
}

#[test]
fn the_robot_in_mujoco_survives_pushes_of_two_newton_seconds_and_falls_by_pushes_of_nine() {
    for contacts in ["", "--soft"] {
        for (impulse, falls) in [("[2,0,0]", false), ("[0,2,0]", false), ("[9,0,0]", true), ("[0,9,0]", true)] {
            let push = format!("plant.push_impulse={impulse}");
            let (output, summary) = run_mujoco(contacts, &["duration=10", "plant.push_time=4.5", &push]);
            let errors = String::from_utf8_lossy(&output.stderr);
            assert_eq!(summary["fell"], falls, "{impulse} N·s, {contacts}: {errors}");
        }
    }
}

#[test]
fn the_study_of_pushes_walks_as_far_as_the_session() {
    let push = ["duration=4", "plant.push_impulse=[0,2,0]", "plant.push_time=2"];
    let code = format!(
        "import sys\nsys.path.insert(0, 'plant/foreign/mujoco')\nimport pushes\nwalk = pushes.Walk({:?}, {push:?}, False)\n\
         first = walk.place()\nassert walk.until(4.0)\nprint(walk.place() - first)",
        env!("CARGO_BIN_EXE_biped")
    );
    let study = Command::new(python_with_package()).args(["-B", "-c", &code]).output().expect("Python");
    let errors = String::from_utf8_lossy(&study.stderr);
    let study: f64 = String::from_utf8_lossy(&study.stdout).trim().parse().unwrap_or_else(|_| panic!("{errors}"));
    let (_, session) = run_mujoco("", &push);
    let session = number(&session, "distance_m");
    assert!(session > 0.2 && (study - session).abs() < 1e-9, "{study} m beside {session} m");
}

#[test]
fn another_robot_walks_alike_with_numpy_as_controller_and_with_mujoco_as_plant() {
    let robot = RobotFile::new(&shanks(1.2));
    let setting = robot.setting();
    let settings = ["duration=4", &setting];
    let (_, ours) = run("walk", &["--robot", robot.path(), "--set", settings[0]]);
    let numpy = run_python("walk", "walk.py", &settings);
    let (output, mujoco) = run_mujoco("", &settings);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let ours = number(&ours, "distance_m");
    for (theirs, share) in [(&numpy, 0.01), (&mujoco, 0.02)] {
        let theirs = number(theirs, "distance_m");
        assert!(ours > 0.2 && (theirs / ours - 1.0).abs() < share, "{theirs} m beside {ours} m");
    }
}

#[test]
fn a_missing_python_package_is_reported_with_its_install_command() {
    // -S hides all installed packages
    for (role, script, packages) in [
        ("--controller", "controller/foreign/python/walk.py", "iceoryx2==0.10.0 numpy"),
        ("--plant", "plant/foreign/mujoco/plant.py", "CLONE numpy mujoco"),
    ] {
        let (output, _) = run("walk", &[role, &format!("{} -S {script}", python().display())]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains(&format!("pip install {packages}")) && !errors.contains("Traceback"), "{errors}");
    }
}

#[test]
fn a_foreign_controller_that_dies_or_never_answers_is_named_and_leaves_nothing() {
    let crash = format!("{} -c \"raise ValueError('no legs')\"", python().display());
    let (output, _) = run("stand", &["--controller", &crash, "--respawn", "1"]);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(4), "{errors}");
    assert!(errors.contains("restarting it"), "{errors}");
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
