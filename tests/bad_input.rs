//! Claims about bad input: one clear sentence, its exit code, and nothing left behind.

#![expect(clippy::expect_used, reason = "a test may panic")]

use std::process::Command;

/// Exit code and standard error of `biped ARGUMENTS`.
fn biped(arguments: &[&str]) -> (Option<i32>, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_biped")).args(arguments).output().expect("the program starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

fn refused(arguments: &[&str], words: &[&str]) {
    let (code, errors) = biped(arguments);
    assert_eq!(code, Some(2), "{arguments:?}: {errors}");
    for word in words {
        assert!(errors.contains(word), "{arguments:?} said {errors:?}, but not {word:?}");
    }
    assert!(!errors.contains("panicked"), "{errors}");
}

#[test]
fn a_bad_value_is_refused_by_its_key_in_every_role() {
    for role in ["run", "plant", "controller"] {
        refused(&[role, "walk", "--set", "plant.dt=0"], &["plant.dt = 0", "greater than 0"]);
        refused(&[role, "walk", "--set", "plant.friction=nan"], &["plant.friction = NaN", "finite"]);
        refused(&[role, "walk", "--set", "bodies.trunk.mass=-3"], &["bodies.trunk.mass = -3", "greater than 0"]);
        refused(&[role, "walk", "--set", "plant.fricton=1"], &["--set plant.fricton=1", "`friction`"]);
        refused(&[role, "missing.toml"], &["missing.toml", "walk-literal"]);
    }
}

#[test]
fn a_bad_file_is_shown_with_line_and_caret() {
    let path = std::env::temp_dir().join(format!("biped-test-{}-bad.toml", std::process::id()));
    let name = path.to_string_lossy().into_owned();
    for (text, words) in [
        ("[plant]\nfricton = 0.5\n", &["line 2", "^", "`friction`"][..]),
        ("[plant]\nlaw = \"Coulomb\"\n", &["line 2", "^", "`Aligned`"]),
        ("duration = \n", &["line 1", "^"]),
        ("duration = inf\n", &["duration = inf", "finite"]),
        ("[controller]\n[[bodies]]\nname = \"a\"\nmass = 1\nsize = [1, 1, 1]\n", &["joints = 0", "Table 1"]),
    ] {
        std::fs::write(&path, text).expect("a file");
        refused(&["run", &name], &[words, &[name.as_str()]].concat());
    }
    std::fs::remove_file(path).expect("our own file");
}

#[test]
fn wrong_usage_is_refused() {
    refused(&["fly"], &["fly"]);
    refused(&["run", "walk", "--patience", "0"], &["seconds"]);
    refused(&["run", "walk", "--in-process", "--realtime"], &["--in-process"]);
    refused(&["plant", "walk", "--session", "../x"], &["../x", "letters"]);
    refused(&["run", "walk", "--swap", "inf=biped controller"], &["a simulated time"]);
}

#[test]
fn a_gait_that_no_foot_can_bear_falls_or_walks_but_never_panics() {
    let gait = ["--in-process", "--quiet", "--set", "duration=3", "--set", "controller.release_x2=0.101"];
    let (code, errors) = biped(&[&["run", "walk"], &gait[..]].concat());
    assert!(code == Some(0) || code == Some(7), "{code:?} {errors}");
}

#[test]
fn help_documents_the_exit_codes() {
    let output = Command::new(env!("CARGO_BIN_EXE_biped")).arg("--help").output().expect("the program starts");
    let help = String::from_utf8_lossy(&output.stdout);
    for word in ["2 wrong usage", "3 the other process", "7 the robot fell", "130 interrupted"] {
        assert!(help.contains(word), "{help}");
    }
}
