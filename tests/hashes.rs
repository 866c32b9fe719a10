//! Claim: every built-in scene has its published hash, with any number of threads and processes.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::run_two;
use std::process::Command;

/// The published table.
const PUBLISHED: &str = include_str!("../messages/scenes/hashes.txt");

/// The table that this build computes.
fn table(threads: &str) -> String {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    let output = command.args(["list", "--hashes"]).env("RAYON_NUM_THREADS", threads).output();
    String::from_utf8(output.expect("the program starts").stdout).expect("text")
}

#[test]
fn whole_runs_have_the_published_hashes_on_one_thread_and_on_many() {
    for threads in ["1", "8"] {
        let table = table(threads);
        let changed: Vec<_> = table.lines().filter(|line| !PUBLISHED.lines().any(|known| known == *line)).collect();
        assert!(
            changed.is_empty(),
            "changed hashes on {threads} threads (launch/laboratory/src/hashes.rs documents how to renew them):\n{}",
            changed.join("\n")
        );
        assert_eq!(table.lines().count(), PUBLISHED.lines().count());
    }
}

#[test]
fn two_processes_have_the_published_hashes() {
    let rows: Vec<_> = PUBLISHED.lines().skip(1).collect();
    std::thread::scope(|scope| {
        for half in [0, 1] {
            let rows = rows.iter().skip(half).step_by(2);
            scope.spawn(|| {
                for row in rows {
                    let words: Vec<_> = row.split_whitespace().collect();
                    let shortened: f64 = words[3].parse::<f64>().expect("seconds").min(1.0);
                    assert_eq!(run_two(words[0], &[&format!("duration={shortened}")]).hash(), words[1], "{row}");
                }
            });
        }
    });
}
