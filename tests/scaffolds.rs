//! Claims about `biped new`: what it makes runs at once, comes out of the program, and never takes the place of something else.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use common::fresh_path;
use languages::python;
use std::path::Path;
use std::process::{Command, Output};

fn biped(folder: &Path, arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).current_dir(folder).output().expect("the program starts")
}

fn succeeds(output: &Output, what: &str) {
    assert_eq!(output.status.code(), Some(0), "{what}: {}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn a_new_controller_runs_conforms_and_passes_its_own_test_away_from_this_repository() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for (origin, scene, settings) in [("stand", "stand", "duration=1"), ("walk", "walk", "duration=3")] {
        succeeds(&biped(&folder, &["new", "controller", origin, "--from", origin]), "new");
        let command = format!("{} {origin}/controller.py", python().display());
        let run = biped(&folder, &["run", scene, "--quiet", "--set", settings, "--controller", &command]);
        succeeds(&run, origin);
        let own = Command::new(python()).arg(folder.join(origin).join("test_controller.py")).output().expect("Python");
        succeeds(&own, "its own test");
        let readme = std::fs::read_to_string(folder.join(origin).join("README.md")).expect("a file");
        assert!(
            readme.contains(&format!("biped run {scene} --controller \"python3 {origin}/controller.py\"")),
            "{readme}"
        );
    }
    let command = format!("{} stand/controller.py", python().display());
    succeeds(&biped(&folder, &["conform", "--controller", &command]), "conform");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_new_scene_and_a_new_robot_are_files_that_run() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    succeeds(&biped(&folder, &["new", "scene", "mine", "--from", "drop"]), "new scene");
    succeeds(&biped(&folder, &["run", "mine.toml", "--quiet", "--in-process"]), "the scene");
    succeeds(&biped(&folder, &["new", "robot", "robot.toml"]), "new robot");
    let walk = ["run", "walk", "--quiet", "--in-process", "--robot", "robot.toml", "--set", "duration=2"];
    succeeds(&biped(&folder, &walk), "the robot");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn what_is_there_is_kept_and_named() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for what in ["controller", "scene", "robot"] {
        succeeds(&biped(&folder, &["new", what, "mine"]), what);
        let again = biped(&folder, &["new", what, "mine"]);
        let sentence = String::from_utf8_lossy(&again.stderr).into_owned();
        assert_eq!(again.status.code(), Some(2), "{sentence}");
        assert!(sentence.contains("is there already") && sentence.lines().count() == 1, "{sentence}");
        let _ = std::fs::remove_file(folder.join("mine.toml"));
    }
    let unknown = biped(&folder, &["new", "scene", "other", "--from", "no-such"]);
    assert_eq!((unknown.status.code(), folder.join("other.toml").exists()), (Some(2), false));
    std::fs::remove_dir_all(folder).expect("our own folder");
}
