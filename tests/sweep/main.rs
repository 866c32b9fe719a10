//! Claims about `biped sweep`: its runs are those of `biped run`, shards and interrupted sweeps write the same files as one, thresholds
//! are found where analysis puts them, and bad arguments are refused in one sentence.

#![expect(clippy::expect_used, reason = "a test may panic")]

#[path = "../common/mod.rs"]
mod common;

mod edges;

use common::fresh_path;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

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
            assert_eq!(column(&table, "outcome")[k], if fell { "fell" } else { "completed" });
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
    assert_eq!(outcomes, ["completed", "fell"]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn sharded_and_interrupted_sweeps_write_the_same_files_as_one_sweep() {
    let folder = fresh_path("sweep");
    let ranges = ["drop", "plant.friction=0:0.8:3", "plant.restitution=0,0.5", "--set", "duration=0.4"];
    let files = |folder: &Path| {
        ["sweep.csv", "sweep.svg", "sweep.parquet"].map(|name| std::fs::read(folder.join(name)).expect(name))
    };
    let printed = sweep(&ranges, &folder.join("whole"));
    assert!(printed.contains("6 of 6 runs survive"), "{printed}");
    let whole = files(&folder.join("whole"));
    let table = String::from_utf8(whole[0].clone()).expect("text");
    assert_eq!(column(&table, "plant.friction"), ["0", "0", "0.4", "0.4", "0.8", "0.8"]);
    assert_eq!(column(&table, "plant.restitution"), ["0", "0.5", "0", "0.5", "0", "0.5"]);

    let mut shards: Vec<PathBuf> = Vec::new();
    for shard in ["2/2", "1/2"] {
        sweep(&[&ranges[..], &["--shard", shard]].concat(), &folder);
        shards.push(folder.join(format!("sweep-{}.csv", shard.replace('/', "-of-"))));
    }
    let shards: Vec<&str> = shards.iter().map(|file| file.to_str().expect("a name")).collect();
    sweep(&[&ranges[..], &["--merge"], &shards].concat(), &folder.join("merged"));
    assert!(files(&folder.join("merged")) == whole, "merged shards differ");

    // One shard alone is not the whole, and another sweep's table is refused.
    for (more, word) in [(&["--merge", shards[0]][..], "3 of 6 runs are in none"), (&["duration=1,2"], "given twice")] {
        let refused = output(&[&ranges[..], more].concat(), &folder.join("refused"));
        let words = String::from_utf8_lossy(&refused.stderr);
        assert!(refused.status.code() == Some(2) && words.contains(word), "{words}");
    }
    let other = output(&["drop", "plant.friction=0:0.8:3"], &folder.join("whole"));
    let words = String::from_utf8_lossy(&other.stderr);
    assert_eq!(other.status.code(), Some(2), "{words}");
    assert!(words.contains("is the table of another sweep") && words.contains("--out"), "{words}");
    assert!(words.lines().count() == 1 && files(&folder.join("whole")) == whole, "{words}");

    // A table that was cut in the middle of a row. A finished run is not repeated, so its false figure stays.
    let cut = folder.join("cut");
    std::fs::create_dir_all(&cut).expect("a folder");
    let lines: Vec<&str> = table.lines().collect();
    let false_row = lines[3].replacen("completed,,0.4,", "completed,,0.7,", 1);
    assert_ne!(false_row, lines[3]);
    let rest = [lines[0], lines[1], &false_row, &lines[6][..40]].join("\n");
    std::fs::write(cut.join("sweep.csv"), rest).expect("a table");
    sweep(&ranges, &cut);
    assert_eq!(read(&cut.join("sweep.csv")), table.replacen(lines[3], &false_row, 1));
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_killed_sweep_goes_on_where_it_stopped() {
    let folder = fresh_path("sweep");
    let ranges = ["sweep", "walk", "controller.speed=0.1:0.2:8", "--set", "duration=4"];
    let path = folder.join("killed/sweep.csv");
    let mut child = biped(&ranges).arg("--out").arg(folder.join("killed")).spawn().expect("the program starts");
    let start = Instant::now();
    while read(&path).lines().count() < 4 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    kill(Pid::from_raw(child.id() as i32), Signal::SIGKILL).expect("our own child");
    child.wait().expect("an end");
    let begun = read(&path);
    let finished: Vec<&str> = begun.split_inclusive('\n').filter(|line| line.ends_with('\n')).skip(2).collect();
    assert!((1..8).contains(&finished.len()), "killed too early or too late to tell anything: {begun}");
    sweep(&ranges[1..], &folder.join("killed"));
    sweep(&ranges[1..], &folder.join("whole"));
    let table = read(&path);
    assert!(finished.iter().all(|row| table.contains(row)), "{begun}\n{table}");
    assert_eq!(table, read(&folder.join("whole/sweep.csv")));
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn seeds_change_what_is_random_and_nothing_else() {
    let folder = fresh_path("sweep");
    let table = |arguments: &[&str], name: &str| {
        sweep(&[&["walk", "--set", "duration=1"], arguments].concat(), &folder.join(name));
        read(&folder.join(name).join("sweep.csv"))
    };
    let table = table(&["link.loss=0,0.2", "seeds=2"], "random");
    assert_eq!(column(&table, "seed"), ["1", "2", "1", "2"]);
    let hashes = column(&table, "trajectory_hash");
    assert!(hashes[0] == hashes[1] && hashes[2] != hashes[3], "{hashes:?}");
    let single = common::run("walk", &["duration=1", "link.loss=0.2", "link.seed=2", "plant.seed=2"]);
    assert_eq!(single.hash(), hashes[3]);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_bad_argument_is_refused_in_one_sentence() {
    let folder = fresh_path("sweep");
    let refused: [(&[&str], &[&str]); 27] = [
        (&["drop", "plant.fricton=0,1"], &["plant.fricton=0: ", "did you mean `friction`"]),
        (&["drop", "plant.friction"], &["plant.friction: ", "plant.friction=0.1:0.9:5"]),
        (&["drop", "plant.friction="], &["plant.friction=: ", "plant.friction=0.1:0.9:5"]),
        (&["drop", "plant.friction=1,,2"], &["two commas"]),
        (&["drop", "plant.friction=0:1"], &["0:1 is no range", "a:b:n"]),
        (&["drop", "plant.friction=0:1:1"], &["`1` values", "from 2 to 100000"]),
        (&["drop", "plant.friction=1:1:5"], &["1:1:5 is empty"]),
        (&["drop", "plant.friction=log:0:1:5"], &["logarithmic", "greater than 0"]),
        (&["drop", "plant.friction=0:-1:3"], &["plant.friction", "negative"]),
        (&["drop", "plant.friction=0,0"], &["plant.friction", "0 is given twice"]),
        (&["drop", "plant.friction=0,1", "plant.friction=2"], &["plant.friction", "given twice"]),
        (&["drop", "plant.friction=0,1", "--set", "plant.friction=2"], &["plant.friction", "given twice"]),
        (&["drop", "plant.friction=0,1", "--edge", "plant.friction=0:1"], &["plant.friction", "given twice"]),
        (
            &["drop", "plant.friction=0:1:1000", "plant.restitution=0:1:1000"],
            &["1000000 runs", " h on", "at most 100000"],
        ),
        (&["drop", "plant.encoder_bits=8:16:4"], &["plant.encoder_bits=", "u32"]),
        (&["drop", "seeds=3"], &["seeds", "nothing in drop is random"]),
        (&["walk", "seeds=0"], &["seeds=0", "from 1 to 1000"]),
        (&["walk", "seeds=2", "link.seed=1,2", "link.loss=0.1"], &["link.seed", "given twice"]),
        (&["walk", "seed=1,2"], &["seed", "seeds=N"]),
        (&["wlak", "duration=1,2"], &["wlak", "did you mean `walk`"]),
        (&["drop", "--edge", "plant.friction=0:1"], &["--edge", "no feet", "--survival"]),
        (&["walk", "--edge", "plant.friction=0,1"], &["--edge plant.friction=0,1", "one range"]),
        (&["walk", "--edge", "plant.encoder_bits=8:16:9"], &["plant.encoder_bits=8.5", "u32"]),
        (&["walk", "--edge", "plant.friction=0.1:1", "--tolerance", "-1"], &["--tolerance -1", "greater than 0"]),
        (&["drop", "duration=1,2", "--survival", "distnce_m<1"], &["`distnce_m`", "did you mean `distance_m`"]),
        (&["drop", "duration=1,2", "--survival", "distance_m<x"], &["--survival distance_m<x", "finite number"]),
        (&["drop", "duration=1,2", "--merge", "README.md"], &["README.md is the table of another sweep"]),
    ];
    for (arguments, expected) in refused {
        let output = output(arguments, &folder);
        let words = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{arguments:?}: {words}");
        assert!(words.lines().count() == 1, "{arguments:?}: {words}");
        assert!(expected.iter().all(|word| words.contains(word)), "{arguments:?}: {words}");
        assert!(!folder.exists(), "{arguments:?} left a folder");
    }
    // The argument parser refuses these, and adds a line about help.
    for (arguments, word) in [
        (&["drop"][..], "KEY=RANGE"),
        (&["drop", "duration=1,2", "--shard", "3/2"], "i from 1 to n"),
        (&["drop", "duration=1,2", "--tolerance", "1"], "--edge"),
    ] {
        let output = output(arguments, &folder);
        let words = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && words.contains(word), "{arguments:?}: {words}");
    }
}
