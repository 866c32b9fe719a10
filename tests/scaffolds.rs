//! Claims about `biped new`: its files run at once, come out of the program, and never replace an existing file.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use common::fresh_path;
use languages::{libraries, python, python_with_package};
use std::path::{Path, PathBuf};
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
fn new_controllers_in_rust_build_by_path_run_conform_and_pass_their_own_tests() {
    // within the target folder, so that it is built with the options of this repository
    let folder = PathBuf::from(env!("CARGO_TARGET_TMPDIR")).join("scaffold-rust");
    std::fs::create_dir_all(&folder).expect("a folder");
    let here = env!("CARGO_MANIFEST_DIR");
    for name in ["stands", "walks"] {
        let (mine, from) = (folder.join(name), name.trim_end_matches('s'));
        let _ = std::fs::remove_dir_all(&mine);
        succeeds(&biped(&folder, &["new", "controller", name, "--rust", "--from", from, "--tree", here]), "new");
        std::fs::copy(Path::new(here).join("Cargo.lock"), mine.join("Cargo.lock")).expect("a file");
        for what in ["test", "build"] {
            let mut cargo = Command::new(env!("CARGO"));
            cargo.args([what, "--release", "--quiet"]).current_dir(&mine);
            cargo.env("CARGO_TARGET_DIR", folder.join("target"));
            // what the libraries compute is the same without optimisation, and their build is most of the time of this test
            cargo.env("CARGO_PROFILE_RELEASE_OPT_LEVEL", "0").env("CARGO_PROFILE_RELEASE_DEBUG", "0");
            let built = cargo.output().expect("cargo");
            succeeds(&built, what);
        }
        std::fs::remove_dir_all(mine).expect("our own folder");
    }
    stands_and_conforms(&folder, "target/release/stands");
    let walk = ["run", "walk", "--quiet", "--set", "duration=2", "--controller", "target/release/walks"];
    succeeds(&biped(&folder, &walk), "walk");
}

/// A standing controller keeps the robot up, and keeps the rules.
fn stands_and_conforms(folder: &Path, command: &str) {
    let run = ["run", "stand", "--quiet", "--set", "duration=1", "--out", "out", "--controller", command];
    succeeds(&biped(folder, &run), command);
    let summary = std::fs::read_to_string(folder.join("out/summary.json")).expect("a file");
    assert!(summary.contains("\"fell\": false"), "{summary}");
    succeeds(&biped(folder, &["conform", "--controller", command]), "conform");
}

#[test]
fn new_controllers_in_c_and_cpp_build_run_and_conform() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for (name, options) in [("c", vec!["--c"]), ("cpp", vec!["--cpp"]), ("walk", vec!["--c", "--from", "walk"])] {
        succeeds(&biped(&folder, &[vec!["new", "controller", name], options].concat()), name);
        succeeds(&make(&folder.join(name), &[&format!("BIPED_LIB={}", libraries().display())]), name);
    }
    stands_and_conforms(&folder, "c/controller");
    stands_and_conforms(&folder, "cpp/controller");
    let walk = ["run", "walk", "--quiet", "--set", "duration=2", "--controller", "walk/controller"];
    succeeds(&biped(&folder, &walk), "walk");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

fn make(folder: &Path, arguments: &[&str]) -> Output {
    Command::new("make").arg("-C").arg(folder).args(arguments).env_remove("BIPED_LIB").output().expect("make")
}

#[test]
fn a_missing_library_compiler_or_clone_is_named_in_one_sentence() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for (option, compiler) in [("--c", "CC=no-such-compiler"), ("--cpp", "CXX=no-such-compiler")] {
        succeeds(&biped(&folder, &["new", "controller", "mine", option]), option);
        let library = format!("BIPED_LIB={}", libraries().display());
        for (arguments, words) in [
            (vec![], "there is no libbiped_c.so in BIPED_LIB=''"),
            (vec![library.as_str(), compiler], "compiler 'no-such-compiler': install g"),
        ] {
            let output = make(&folder.join("mine"), &arguments);
            let errors = String::from_utf8_lossy(&output.stderr).into_owned();
            let ours: Vec<_> = errors.lines().filter(|line| line.starts_with("error: ")).collect();
            assert!(!output.status.success() && ours.len() == 1 && ours[0].contains(words), "{errors}");
        }
        std::fs::remove_dir_all(folder.join("mine")).expect("our own folder");
    }
    for (arguments, words) in [
        (&["mine", "--rust", "--tree", "."][..], "no clone of biped"),
        (&["mine", "--c", "--tree", "no-such-folder"], "no clone of biped"),
        (&["mine", "--tree", "."], "Python needs nothing from there"),
        (&["Mine", "--rust"], "\"Mine\" cannot name a Rust package"),
        (&["mine", "--cpp", "--from", "walk"], "in Python, Rust and C"),
    ] {
        let refused = biped(&folder, &[&["new", "controller"], arguments].concat());
        let sentence = String::from_utf8_lossy(&refused.stderr).into_owned();
        assert!(refused.status.code() == Some(2) && sentence.contains(words), "{arguments:?}: {sentence}");
        assert!(sentence.lines().count() == 1 && !folder.join("mine").exists(), "{sentence}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_new_folder_asks_for_the_library_unless_a_clone_is_given() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for (name, options) in [("asks", &[][..]), ("knows", &["--tree", env!("CARGO_MANIFEST_DIR")])] {
        succeeds(&biped(&folder, &[&["new", "controller", name, "--c"], options].concat()), name);
        let readme = std::fs::read_to_string(folder.join(name).join("README.md")).expect("a file");
        assert_eq!(readme.contains("BIPED_LIB=CLONE"), options.is_empty(), "{readme}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn the_commands_of_a_new_folder_are_for_a_shell_also_if_its_name_has_a_space() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for (name, language) in [("my legs", "--python"), ("my C legs", "--c"), ("it's C++", "--cpp")] {
        succeeds(&biped(&folder, &["new", "controller", name, language]), name);
        let readme = std::fs::read_to_string(folder.join(name).join("README.md")).expect("a file");
        let run = readme.lines().find(|line| line.starts_with("biped run")).expect("a command");
        // A shell and the program get the same name.
        let script = run.replace("biped run", "printf '%s\n'");
        let words = Command::new("sh").args(["-c", &script]).output().expect("a shell");
        let words = String::from_utf8(words.stdout).expect("text");
        let command = words.lines().last().expect("a command");
        let words = Command::new("sh").args(["-c", &format!("printf '%s\n' {command}")]).output().expect("a shell");
        let words = String::from_utf8(words.stdout).expect("text");
        assert!(words.lines().any(|word| word.starts_with(&format!("{name}/controller"))), "{run}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn mujoco_as_a_new_plant_is_walked_away_from_this_repository() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    succeeds(&biped(&folder, &["new", "plant", "mine", "--mujoco"]), "new");
    let command = format!("{} mine/plant.py", python_with_package().display());
    let run = ["run", "walk", "--quiet", "--set", "duration=2", "--out", "out", "--plant", &command];
    succeeds(&biped(&folder, &run), "the plant");
    let summary = std::fs::read_to_string(folder.join("out/summary.json")).expect("a file");
    assert!(summary.contains("\"fell\": false"), "{summary}");
    let own = Command::new(python_with_package()).arg(folder.join("mine/test_plant.py")).output().expect("Python");
    succeeds(&own, "its own test");
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
fn the_scripts_of_the_peers_come_with_their_scenes_and_packages() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    succeeds(&biped(&folder, &["new", "peers", "peers"]), "new peers");
    let listed = std::fs::read_to_string(folder.join("peers/requirements.txt")).expect("a file");
    assert!(listed.contains("mujoco-core=="), "{listed}");
    let mut script = Command::new("python3");
    let ran = script.args(["peers/run.py", "peers", "--help"]).current_dir(&folder).output().expect("Python");
    succeeds(&ran, "its script");
    let scenes = std::fs::read_to_string(folder.join("peers/scenes.toml")).expect("a file");
    assert_eq!(scenes.matches("[[scenes]]").count(), 12);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_name_with_control_characters_or_without_its_parent_is_refused_and_nothing_is_made() {
    let folder = fresh_path("scaffold");
    std::fs::create_dir(&folder).expect("a folder");
    for what in ["controller", "plant", "peers", "scene", "robot"] {
        for (name, words) in [
            ("two\nlines", "has a control character"),
            ("bell\u{7}", "has a control character"),
            ("a/b/c", "there is no folder a/b: make it first"),
            ("..", "names no new file or folder"),
        ] {
            let refused = biped(&folder, &["new", what, name]);
            let sentence = String::from_utf8_lossy(&refused.stderr).into_owned();
            assert_eq!(refused.status.code(), Some(2), "{what} {name:?}: {sentence}");
            assert!(sentence.contains(words) && sentence.lines().count() == 1, "{what} {name:?}: {sentence}");
        }
    }
    assert_eq!(std::fs::read_dir(&folder).expect("a folder").count(), 0);
    succeeds(&biped(&folder, &["new", "scene", "my own"]), "new scene");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn existing_files_are_kept_and_named() {
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
