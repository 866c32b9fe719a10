//! Claims about `biped sweep`: its runs are those of `biped run`, shards and interrupted sweeps write the same files as one, thresholds
//! are found where analysis puts them, and bad arguments are refused in one sentence.

#![expect(clippy::expect_used, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;
mod edges;
mod parts;
mod refusals;
mod refused_runs;

use common::fresh_path;
use serde_json::Value;
use std::path::Path;
use std::process::{Command, Output, Stdio};

fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).arg("--quiet").stdin(Stdio::null());
    command
}

fn output(arguments: &[&str], folder: &Path) -> Output {
    biped(&[&["sweep"], arguments].concat()).arg("--out").arg(folder).output().expect("the program starts")
}

/// Runs a sweep. Returns what it prints.
fn sweep(arguments: &[&str], folder: &Path) -> String {
    let output = output(arguments, folder);
    assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).expect("text")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// The column of a table with this name.
fn column(table: &str, name: &str) -> Vec<String> {
    let mut rows = table.lines().skip(1).map(|line| line.split(','));
    let place = rows.next().expect("names").position(|known| known == name).expect(name);
    rows.map(|mut row| row.nth(place).expect("a cell").to_string()).collect()
}

fn numbers(table: &str, name: &str) -> Vec<f64> {
    column(table, name).iter().map(|cell| cell.parse().expect("a number")).collect()
}

#[test]
fn every_run_of_a_sweep_is_that_of_a_single_run_with_the_same_digits() {
    let folder = fresh_path("sweep");
    for (scene, key, values, fixed) in [
        ("drop", "plant.friction", &["0", ".5"][..], &["duration=1"][..]),
        ("walk", "plant.push_impulse.1", &["0", "6"], &["duration=6", "plant.push_time=3"]),
    ] {
        let fixed: Vec<&str> = fixed.iter().flat_map(|setting| ["--set", setting]).collect();
        let range = format!("{key}={}", values.join(","));
        let out = folder.join(scene);
        sweep(&[&[scene, &range], &fixed[..]].concat(), &out);
        let table = read(&out.join("sweep.csv"));
        assert_eq!(column(&table, key), values);
        for (k, value) in values.iter().enumerate() {
            let (out, set) = (out.join(value), format!("{key}={value}"));
            let single = [&["run", scene, "--in-process", "--set", &set], &fixed[..]].concat();
            let ended = biped(&single).arg("--out").arg(&out).output().expect("the program starts");
            let json: Value = serde_json::from_str(&read(&out.join("summary.json"))).expect("a summary");
            let fell = json["fell"].as_bool().expect("yes or no");
            assert_eq!(ended.status.code(), Some(if fell { 7 } else { 0 }));
            let (printed, outcome) = (String::from_utf8_lossy(&ended.stdout), &column(&table, "outcome")[k]);
            let word = if fell { "FELL after" } else { outcome };
            assert!(printed.contains(&format!("  {:<20} {word}", "outcome")), "{outcome} for {printed}");
            assert!((outcome == "fell") == fell, "{outcome}");
            let mut compared = 0;
            for name in table.lines().nth(1).expect("names").split(',') {
                let (key, index) = name.split_once('[').unwrap_or((name, "]"));
                let value = match index.trim_end_matches(']').parse::<usize>() {
                    Ok(index) => &json[key][index],
                    Err(_) => &json[key],
                };
                let digits = match value {
                    Value::String(text) => text.clone(),
                    Value::Number(number) => number.to_string(),
                    _ => continue,
                };
                assert_eq!(column(&table, name)[k], digits, "{set}: {name}");
                compared += 1;
            }
            assert!(compared > 20, "{compared}");
        }
        let hashes = column(&table, "trajectory_hash");
        assert_ne!(hashes[0], hashes[1], "the key has an effect");
    }
    let outcomes = column(&read(&folder.join("walk/sweep.csv")), "outcome");
    assert_eq!(outcomes, ["no fall", "fell"]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn seeds_change_random_quantities_and_nothing_else() {
    let folder = fresh_path("sweep");
    let run = |arguments: &[&str], name: &str| {
        sweep(&[&["walk", "--set", "duration=1"], arguments].concat(), &folder.join(name));
        read(&folder.join(name).join("sweep.csv"))
    };
    let table = run(&["link.loss=0,0.2", "seeds=2"], "random");
    assert_eq!(column(&table, "seed"), ["1", "2", "1", "2"]);
    let hashes = column(&table, "trajectory_hash");
    assert!(hashes[0] == hashes[1] && hashes[2] != hashes[3], "{hashes:?}");
    let single = common::run("walk", &["duration=1", "link.loss=0.2", "link.seed=2", "plant.seed=2"]);
    assert_eq!(single.hash(), hashes[3]);
    let table = run(&["plant.ground.random.height=0,0.002", "seeds=2"], "tiles");
    let hashes = column(&table, "trajectory_hash");
    assert!(hashes[0] == hashes[1] && hashes[2] != hashes[3], "{hashes:?}");
    let tiles = ["duration=1", "plant.ground.random.height=0.002", "plant.ground.random.seed=2"];
    assert_eq!(common::run("walk", &tiles).hash(), hashes[3]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}
