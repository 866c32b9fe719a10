//! Claims about numbers out of range, and about empty and damaged files.

use super::{biped, refused};
use messages::load::{SCENES, load};

#[test]
fn a_number_that_is_negative_too_large_or_no_number_is_refused_by_the_rule_of_its_option() {
    refused(&["run", "walk", "--realtime", "--speed", "-1"], &["'-1' for '--speed", "a factor from 0.001 to 100"]);
    refused(&["run", "walk", "--patience", "-1"], &["'-1' for '--patience", "a number of seconds from 0.1"]);
    refused(&["run", "walk", "--respawn", "x"], &["'x' for '--respawn", "a whole number of 0 or more is needed"]);
    refused(&["step", "-1"], &["'-1' for '[PERIODS]'", "a whole number of 0 or more is needed"]);
    refused(&["step", "99999999999999999999999"], &["for '[PERIODS]'", "a smaller number is needed"]);
    for empty in [&["run", "walk", "--robot", ""], &["conform", "stand", "--controller", ""]] {
        refused(empty, &["a value is required for", empty[2]]);
    }
    refused(&["run", "walk", "--set", "robot="], &["error: robot = \"\": there is no such file"]);
    refused(&["robustness", "--jitter", "much"], &["'much' for '--jitter", "a number is needed, such as 0.5"]);
}

#[test]
fn a_tolerance_below_the_rounding_of_a_step_is_refused() {
    for method in ["EventDriven", "StepDoubling"] {
        let set = format!("plant.method={method}");
        let tolerance = "plant.tolerance_step=1e-30";
        refused(
            &["run", "drop", "--set", &set, "--set", tolerance],
            &["plant.tolerance_step = 1e-30", "at least 1e-16"],
        );
    }
}

/// A bound of three digits that is rounded to the nearest number may lie beyond the bound.
#[test]
fn the_greatest_rate_that_a_refusal_names_is_accepted() {
    for step in [0.001, 0.0007, 0.0003] {
        for (scene, key, value) in [
            ("drop", "initial.angular_velocity", "[RATE, 0, 0]"),
            ("stand", "initial.joint_rates", "[0, RATE, 0, 0, 0, 0, 0, 0]"),
        ] {
            let with = |rate: &str| {
                let settings = [
                    format!("plant.dt={step}"),
                    format!("rate={}", 1.0 / step),
                    format!("{key}={}", value.replace("RATE", rate)),
                ];
                load(scene, &settings, SCENES).map_err(|error| error.to_string())
            };
            let sentence = with("1e5").expect_err("half a turn in a step");
            let (_, bound) = sentence.split_once(": at most ").expect("a bound");
            let bound = bound.split(' ').next().expect("a number");
            assert!(with(bound).is_ok(), "{key} of {bound} rad/s is refused, but: {sentence}");
        }
    }
}

/// Cf. dm_control #341: no body has a moment of inertia greater than the sum of the other two.
#[test]
fn an_impossible_inertia_of_a_scene_is_refused() {
    let path = std::env::temp_dir().join(format!("biped-bad-input-{}-inertia.toml", std::process::id()));
    for (inertia, accepted) in [
        ([0.001, 0.001, 0.1], false),
        ([0.1, 0.001, 0.001], false),
        ([0.001, 0.0021, 0.001], false),
        ([0.001, 0.002, 0.001], true),
    ] {
        let text = format!("[[bodies]]\nname = \"cube\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\ninertia = {inertia:?}\n");
        std::fs::write(&path, text).expect("a file");
        let scene = path.to_str().expect("a path");
        match accepted {
            true => assert_eq!(biped(&["model", scene]).0, Some(0), "{inertia:?}"),
            false => refused(
                &["model", scene],
                &["bodies.cube.inertia = ", "each moment of inertia must be at most the sum of the other two"],
            ),
        }
    }
    std::fs::remove_file(&path).expect("a file to remove");
}

#[test]
fn an_empty_scene_and_a_damaged_recording_are_named_with_the_reason() {
    let path = |name: &str| std::env::temp_dir().join(format!("biped-bad-input-{}-{name}", std::process::id()));
    let (scene, recording) = (path("empty.toml"), path("half.mcap"));
    std::fs::write(&scene, " \n").expect("a file");
    refused(&["run", &scene.display().to_string()], &["empty.toml", "the file is empty", "biped new scene"]);
    let file = recording.display().to_string();
    let record = ["run", "slide", "--in-process", "--quiet", "--set", "duration=0.3", "--record", &file];
    assert_eq!(biped(&record).0, Some(0));
    let whole = std::fs::read(&recording).expect("a file");
    std::fs::write(&recording, &whole[..whole.len() / 2]).expect("a file"); // within its only chunk
    let cut = ["half.mcap: the recording contains no ", "because it is cut short: "];
    refused(&["replay", "--plant", &file], &cut);
    refused(&["convert", &file, "--table", &path("table.csv").display().to_string()], &cut);
    assert!(!path("table.csv").exists());
    std::fs::remove_file(scene).expect("our own file");
    std::fs::remove_file(recording).expect("our own file");
}
