//! Sweeps in parts: shards and interrupted sweeps write the same files as one sweep.

use crate::common::{assert_refused, fresh_path};
use crate::{biped, column, output, read, sweep};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

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
        assert_refused(&output(&[&ranges[..], more].concat(), &folder.join("refused")), 2, &[word]);
    }
    let other = output(&["drop", "plant.friction=0:0.8:3"], &folder.join("whole"));
    assert_refused(&other, 2, &["is the table of another sweep", "--out"]);
    assert!(files(&folder.join("whole")) == whole, "the refused sweep changed the files");

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
