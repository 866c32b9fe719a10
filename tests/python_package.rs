//! Claim: `pip install .` makes the Python package `biped` from a clone, without the wheel of iceoryx2, and the package does what its
//! own tests in `launch/python/tests` claim.

mod common;
#[path = "common/languages.rs"]
mod languages;

use languages::python_with_package;
use std::process::Command;

#[test]
fn the_package_builds_from_a_clone_and_its_tests_pass() {
    let python = python_with_package();
    let output = Command::new(python)
        .args(["-W", "error", "-m", "unittest", "discover", "--start-directory", "launch/python/tests"])
        .env("BIPED", env!("CARGO_BIN_EXE_biped"))
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .expect("Python 3");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{printed}");
    let skipped = ["skipped", "Ran 0 tests"].iter().any(|word| printed.contains(word));
    assert!(printed.contains("\nOK\n") && !skipped, "no test may be skipped: {printed}");
}
