//! The results do not depend on how plant and controller are started.

use super::{end, eventually, fresh_folder, session, start};
use std::path::{Path, PathBuf};

fn trajectory_hash(folder: &Path) -> String {
    let text = std::fs::read_to_string(folder.join("summary.json")).expect("a summary");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    json["trajectory_hash"].as_str().expect("a hash").to_string()
}

#[test]
fn two_processes_repeat_the_bits_of_one_process_and_their_own() {
    let run = |name: &str, extra: &[&str]| {
        let folder = fresh_folder(name);
        let out = folder.to_string_lossy().into_owned();
        let arguments = ["run", "walk", "--quiet", "--set", "duration=3", "--out", out.as_str()];
        assert_eq!(end(start(&[&arguments, extra].concat())), (Some(0), String::new()), "{name}");
        let hash = trajectory_hash(&folder);
        std::fs::remove_dir_all(folder).expect("our own folder");
        hash
    };
    let two = run("two", &[]);
    assert_eq!(run("again", &[]), two);
    assert_eq!(run("one", &["--in-process"]), two);
    assert_ne!(run("other", &["--set", "plant.friction=0.69"]), two, "negative case: another scene has another hash");
}

#[test]
fn parallel_sessions_are_independent_and_a_name_is_used_once() {
    let folders = ["alone", "left", "right"].map(fresh_folder);
    let walk = |folder: &Path, extra: &[&str]| {
        let out = folder.to_string_lossy().into_owned();
        start(&[&["run", "walk", "--quiet", "--set", "duration=100", "--out", &out], extra].concat())
    };
    assert_eq!(end(walk(&folders[0], &["--in-process"])), (Some(0), String::new()));
    let (left, right) = (session("left"), session("right"));
    let runs = [walk(&folders[1], &["--session", left.name()]), walk(&folders[2], &["--session", right.name()])];
    eventually("both sessions", || left.members().len() == 3 && right.members().len() == 3);
    let (code, errors) = end(start(&["run", "walk", "--quiet", "--session", left.name()]));
    assert_eq!(code, Some(5), "{errors}");
    assert!(errors.contains(left.name()) && errors.contains("already running"), "{errors}");
    for run in runs {
        assert_eq!(end(run), (Some(0), String::new()));
    }
    let hashes = folders.each_ref().map(|folder| trajectory_hash(folder));
    assert!(hashes.iter().all(|hash| *hash == hashes[0]), "{hashes:?}");
    assert_eq!((left.shm_files(), right.shm_files()), (vec![], vec![]));
    folders.iter().for_each(|folder| std::fs::remove_dir_all(folder).expect("our own folder"));
}

#[test]
fn the_written_scene_is_the_same_run_again() {
    let (first, second) = (fresh_folder("first"), fresh_folder("second"));
    let paths = [&first, &second].map(|folder| folder.to_string_lossy().into_owned());
    let scene = format!("{}/scene.toml", paths[0]);
    let settings = ["--in-process", "--quiet", "--set", "duration=1", "--set", "plant.payload_kg=1"];
    assert_eq!(end(start(&[&["run", "walk", "--out", &paths[0]], &settings[..]].concat())).0, Some(0));
    assert_eq!(end(start(&["run", &scene, "--in-process", "--quiet", "--out", &paths[1]])).0, Some(0));
    assert_eq!(trajectory_hash(&first), trajectory_hash(&second));
    [first, second].iter().for_each(|folder| std::fs::remove_dir_all(folder).expect("our own folder"));
}

#[test]
fn plant_and_controller_start_by_hand_in_either_order() {
    for roles in [["plant", "controller"], ["controller", "plant"]] {
        let session = session(roles[0]);
        let arguments = |role| [role, "walk", "--set", "duration=0.5", "--session", session.name()];
        let first = start(&arguments(roles[0]));
        eventually("the first process's session", || session.shm_files().len() > 5);
        let second = start(&arguments(roles[1]));
        assert_eq!(end(first), (Some(0), String::new()), "{} first", roles[0]);
        assert_eq!(end(second), (Some(0), String::new()), "{} second", roles[1]);
        assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn a_scene_without_a_controller_runs_in_one_process() {
    let folder = fresh_folder("slide");
    let out = folder.to_string_lossy().into_owned();
    assert_eq!(end(start(&["run", "slide", "--quiet", "--out", &out])), (Some(0), String::new()));
    let two = trajectory_hash(&folder);
    assert_eq!(end(start(&["run", "slide", "--quiet", "--in-process", "--out", &out])), (Some(0), String::new()));
    assert_eq!(trajectory_hash(&folder), two);
    std::fs::remove_dir_all(folder).expect("our own folder");
}
