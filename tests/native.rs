//! Claims about controllers in C and C++: the robot stays up, misuse gives an exit code and a sentence, and no files are left.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use common::{fresh_path, scene};
use languages::compile;
use messages::port::{Contract, Pace};
use messages::session::Session;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Runs a scene with a program as its controller. The run has to succeed and to leave no files.
fn run(scene: &str, program: &Path, settings: &[&str]) -> Value {
    let (folder, session) = (fresh_path("native-run"), Session::unique());
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--quiet", "--session", session.name(), "--controller"])
        .arg(program)
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .arg("--out")
        .arg(&folder)
        .output()
        .expect("the program starts");
    let summary = std::fs::read_to_string(folder.join("summary.json")).unwrap_or_default();
    let _ = std::fs::remove_dir_all(folder);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert_eq!((output.status.code(), &*errors), (Some(0), ""), "{}", program.display());
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "left in shared memory");
    serde_json::from_str(&summary).expect("a summary")
}

/// Runs a controller program without a plant, with the environment variables of an empty session; `replaced` changes some of them.
fn alone(program: &Path, replaced: &[(&str, &str)]) -> Output {
    let (session, scene) = (Session::unique(), scene("stand", &[]));
    let output = Command::new(program)
        .envs(Contract::of(&scene, Pace::Lockstep).variables(&session))
        .env("BIPED_SCENE", serde_json::to_string(&scene).expect("JSON"))
        .env("BIPED_PATIENCE", "0.3")
        .envs(replaced.iter().copied())
        .output()
        .expect("the program starts");
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "left in shared memory");
    output
}

#[test]
fn the_standing_controllers_in_c_and_cpp_stand() {
    let c = compile("cc", "-std=c11", "controller/foreign/c/stand.c");
    let cpp = compile("c++", "-std=c++17", "controller/foreign/cpp/stand.cpp");
    let stand = ["controller.gait=\"stand\"", "duration=2"];
    for program in [&c, &cpp] {
        for (scene, settings) in [("stand", &stand[1..]), ("walk", &stand)] {
            let summary = run(scene, program, settings);
            assert_eq!(summary["fell"], false);
            let distance = summary["distance_m"].as_f64().expect("a number");
            assert!(distance.abs() < 5e-3, "{scene}: it stays where it is: {distance}");
        }
    }
    let hashes = [&c, &cpp].map(|program| run("stand", program, &stand)["trajectory_hash"].clone());
    assert_eq!(hashes[0], hashes[1], "the same law, the same bits");
    [c, cpp].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn the_walking_controller_in_c_repeats_the_bits_of_the_one_in_rust() {
    let program = compile("cc", "-std=c11", "controller/foreign/c/walk.c");
    let theirs = run("walk", &program, &["duration=3"]);
    let ours = common::run_two("walk", &["duration=3"]);
    assert_eq!(theirs["trajectory_hash"], ours.hash());
    std::fs::remove_file(program).expect("our own file");
}

#[test]
fn invalid_session_variables_give_an_exit_code_and_one_sentence() {
    let c = compile("cc", "-std=c11", "controller/foreign/c/stand.c");
    let cpp = compile("c++", "-std=c++17", "controller/foreign/cpp/stand.cpp");
    let older = "wire schema=0123456789abcdef\npace=lockstep\nrate=1000 Hz\ndt=0.001 s\nmodel=0\n";
    let cases = [
        ("BIPED_PATIENCE", "0.3", 3, "no plant sent sensors within 0.3 s"),
        ("BIPED_SESSION", "no/such", 2, "cannot name a session"),
        ("BIPED_CONTRACT", "pace=lockstep", 2, "BIPED_CONTRACT"),
        ("BIPED_CONTRACT", older, 5, "0123456789abcdef"),
        ("BIPED_SCENE", "{", 2, "BIPED_SCENE"),
        ("BIPED_PATIENCE", "-1", 2, "BIPED_PATIENCE"),
    ];
    for program in [&c, &cpp] {
        for (variable, value, code, words) in cases {
            let output = alone(program, &[(variable, value)]);
            let errors = String::from_utf8_lossy(&output.stderr);
            assert!(output.status.code() == Some(code) && errors.contains(words), "{}: {errors}", output.status);
            assert!(errors.starts_with("error: ") && errors.lines().count() == 1, "{errors}");
        }
        let by_hand = Command::new(program).env_remove("BIPED_SESSION").output().expect("the program starts");
        let errors = String::from_utf8_lossy(&by_hand.stderr);
        assert!(by_hand.status.code() == Some(2) && errors.contains("biped run SCENE --controller"), "{errors}");
    }
    [c, cpp].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn a_session_with_another_contract_is_refused() {
    let program = compile("cc", "-std=c11", "controller/foreign/c/stand.c");
    let other = "BIPED_CONTRACT=$(echo \"$BIPED_CONTRACT\" | sed s/lockstep/realtime/)";
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", "stand", "--quiet", "--controller", &format!("sh -c '{other} exec {}'", program.display())])
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.code() == Some(5) && errors.contains("realtime"), "{}: {errors}", output.status);
    std::fs::remove_file(program).expect("our own file");
}

#[test]
fn misuse_of_the_c_library_gives_codes_and_sentences() {
    let program = compile("cc", "-std=c11", "tests/foreign/misuse.c");
    let output = alone(&program, &[]);
    let found = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success() && found.is_empty(), "{}: {found}", output.status);
    std::fs::remove_file(program).expect("our own file");
}
