//! A contact problem that a run could not solve is reported, saved to a file, and can be solved again by any law.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::fresh_path;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the program in a folder.
fn biped(folder: &Path, arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.current_dir(folder).args(arguments).output().expect("the program starts")
}

/// Double precision cannot reach a residual of 1e-15 in every step, so a walk with that tolerance ends at its first larger residual.
#[test]
fn an_unsolved_problem_ends_the_run_and_can_be_solved_again_from_its_file() {
    let folder = fresh_path("unsolved");
    std::fs::create_dir(&folder).expect("a folder");
    for process in [&["--in-process"][..], &[]] {
        let run = ["run", "walk", "--quiet", "--set", "plant.tolerance=1e-15", "--set", "plant.law=Aligned"];
        let output = biped(&folder, &[&run[..], process].concat());
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(8), "{errors}");
        let name = errors.rsplit_once("see `biped contact ").and_then(|(_, rest)| rest.split_once('`'));
        let name = name.expect("the name of a file").0;
        for words in ["contact problem of step", "Aligned leaves a residual", "plant.tolerance is 1.0e-15"] {
            assert!(errors.contains(words), "{errors} does not say {words}");
        }
        assert!(folder.join(name).exists(), "{errors}");
        let summary = String::from_utf8_lossy(&output.stdout);
        assert!(summary.contains(" s: unsolved contact problem"), "{summary}");
        assert!(!summary.contains("completed") && !summary.contains("no fall"), "{summary}");

        let all = biped(&folder, &["contact", name]);
        let table = String::from_utf8_lossy(&all.stdout);
        assert_eq!(all.status.code(), Some(0), "{}", String::from_utf8_lossy(&all.stderr));
        for law in messages::scene::Law::ALL {
            assert!(table.contains(&format!("| {law} ")), "{table} has no row of {law}");
        }
        let one = biped(&folder, &["contact", name, "--law", "Aligned"]);
        let table = String::from_utf8_lossy(&one.stdout);
        let rows: Vec<_> = table.lines().filter(|line| line.starts_with("| Aligned")).collect();
        assert!(rows.len() == 1 && !table.contains("EnergyQp"), "{table}");
        let residual: f64 = rows[0].split('|').nth(2).expect("a cell").trim().parse().expect("a number");
        assert!(residual > 1e-20 && residual < 1e-10, "the same residual as in the run: {table}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

/// Laws that iterate or evaluate a formula do not solve a problem to a tolerance, so `plant.tolerance` does not apply to them.
#[test]
fn a_law_without_exact_solutions_is_not_checked_against_the_tolerance() {
    let folder = fresh_path("inexact");
    std::fs::create_dir(&folder).expect("a folder");
    let run = ["run", "slide", "--in-process", "--quiet", "--set", "plant.tolerance=1e-15"];
    let output = biped(&folder, &[&run[..], &["--set", "plant.law=SpringDamper"]].concat());
    assert_eq!(output.status.code(), Some(0), "{}", String::from_utf8_lossy(&output.stderr));
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn an_invalid_contact_problem_file_is_refused_in_one_sentence() {
    let folder = fresh_path("bad");
    std::fs::create_dir(&folder).expect("a folder");
    let good = r#"{"step": 1, "time": 0.1, "law": "Aligned", "residual": null, "tolerance": 1e-9, "problem": {"contacts": 1,
        "tangents": 1, "id": [0], "delassus": [1, 0, 0, 1], "drift": [-1, 0], "friction": [0.5], "approach": [0],
        "gap": [0], "before": [0, 0], "spring": {"stiffness": 0, "damping_ratio": 0, "h": 0}}}"#;
    let cases = [
        ("", "not a contact problem"),
        ("{}", "missing field"),
        (&good.replace("\"step\"", "\"stop\""), "`stop`"),
        (&good.replace("Aligned", "Coulomb"), "expected one of `SpringDamper`"),
        (&good.replace("[-1, 0]", "[-1]"), "drift has 1 numbers, but 2"),
        (&good.replace("[1, 0, 0, 1]", "[1, 3, 0, 1]"), "symmetric"),
        (&good.replace("[0.5]", "[-0.5]"), "negative"),
        (&good.replace("\"tangents\": 1", "\"tangents\": 3"), "1 or 2"),
        (&good.replace("\"contacts\": 1", "\"contacts\": 18446744073709551615"), "contacts"),
        (&good.replace("\"id\": [0]", "\"id\": [900000000000]"), "id 900000000000"),
    ];
    for (text, words) in cases {
        std::fs::write(folder.join("case.json"), text).expect("a file");
        let output = biped(&folder, &["contact", "case.json"]);
        let errors = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{errors}");
        assert!(errors.contains("case.json") && errors.contains(words), "{errors} does not say {words}");
        assert_eq!(errors.trim().lines().count(), 1, "{errors}");
    }
    std::fs::write(folder.join("case.json"), good).expect("a file");
    let output = biped(&folder, &["contact", "case.json"]);
    let table = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0));
    assert!(table.contains("| Aligned            | needs two tangents"), "{table}");
    let missing = biped(&folder, &["contact", "nowhere.json"]);
    assert!(String::from_utf8_lossy(&missing.stderr).contains("nowhere.json"));
    std::fs::remove_dir_all(folder).expect("our own folder");
}
