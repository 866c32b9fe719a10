//! Claims about `biped robustness`: sharded and interrupted sweeps write the same file as one uninterrupted sweep, and bad arguments are refused
//! in one sentence.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::{assert_refused, fresh_path};
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::time::{Duration, Instant};

fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(["robustness", "--quick", "--quiet"]).args(arguments).stdin(Stdio::null());
    command
}

fn output(arguments: &[&str], folder: &Path) -> Output {
    biped(arguments).arg("--out").arg(folder).output().expect("the program starts")
}

/// Runs a sweep. Returns its table and its map.
fn sweep(arguments: &[&str], folder: &Path) -> [String; 2] {
    let output = output(arguments, folder);
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    ["robustness.csv", "robustness.svg"].map(|name| read(&folder.join(name)))
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

#[test]
fn sharded_and_interrupted_sweeps_write_the_same_file_as_one_sweep() {
    let folder = fresh_path("robustness");
    let whole = sweep(&[], &folder.join("whole"));
    let rows: Vec<&str> = whole[0].lines().skip(2).collect();
    assert_eq!(rows.len(), 16);

    // Shards can be merged in any order.
    let mut files: Vec<PathBuf> = Vec::new();
    for shard in ["3/3", "1/3", "2/3"] {
        assert!(output(&["--shard", shard], &folder).status.success(), "{shard}");
        files.push(folder.join(format!("robustness-{}.csv", shard.replace('/', "-of-"))));
    }
    let names: Vec<&str> = files.iter().map(|file| file.to_str().expect("a name")).collect();
    let merged = sweep(&[&["--merge"], &names[..]].concat(), &folder.join("merged"));
    assert_eq!(merged, whole);
    let lacking = output(&["--merge", names[0], names[2]], &folder.join("lacking"));
    assert_refused(&lacking, 2, &["of 16 runs are in none of the files"]);

    // A table that was cut in the middle of a row, with rows in order of completion. Finished runs are not repeated, so a falsified speed stays.
    let cut = folder.join("cut");
    std::fs::create_dir_all(&cut).expect("a folder");
    let head: Vec<&str> = whole[0].lines().take(2).collect();
    let half = |row: &str| row[..row.len() / 2].to_string();
    let false_row = rows[0].replacen("up,,0.", "up,,9.", 1);
    assert_ne!(false_row, rows[0]);
    let rest = [head.join("\n"), rows[7].into(), false_row.clone(), half(rows[3])].join("\n");
    std::fs::write(cut.join("robustness.csv"), rest).expect("a table");
    let resumed = sweep(&[], &cut);
    assert_eq!(resumed[0], whole[0].replacen(rows[0], &false_row, 1));

    // A table that was cut in its first line.
    std::fs::write(cut.join("robustness.csv"), &whole[0][..20]).expect("a table");
    assert_eq!(sweep(&[], &cut), whole);
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn two_sweeps_never_write_one_table() {
    let folder = fresh_path("robustness");
    let long = ["--set", "duration=100000"];
    let mut first = biped(&long).arg("--out").arg(&folder).stderr(Stdio::piped()).spawn().expect("the program starts");
    let start = Instant::now();
    while !read(&folder.join("robustness.csv")).contains("case,") && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(2));
    }
    assert_refused(&output(&long, &folder), 2, &["another sweep is writing", "--out"]);
    kill(Pid::from_raw(first.id() as i32), Signal::SIGTERM).expect("our own child");
    assert_eq!(first.wait().expect("an end").code(), Some(130));
    // Another shard writes another table.
    assert!(output(&["--shard", "1/16"], &folder).status.success());
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn the_walk_tolerates_a_small_delay_but_not_a_large_one() {
    let folder = fresh_path("robustness");
    let [table, map] = sweep(&["--delay", "0,2,12", "--jitter", "0", "--loss", "0,1"], &folder);
    let outcomes: Vec<&str> = table.lines().skip(2).filter_map(|row| row.split(',').nth(7)).collect();
    assert_eq!(outcomes[..3], ["up", "up", "fell"], "{table}");
    assert!(outcomes[3..].iter().all(|outcome| *outcome != "up"), "without any command: {table}");
    assert!(map.contains("loss 0") && map.contains("loss 1") && !map.contains("NaN"), "{map}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

/// With a number for each joint, the fastest of the eight loops limits the walk. With the inertia matrix all loops tolerate more than twice the
/// delay, and the walk has other limits (docs/RELIABILITY.md).
#[test]
fn the_walk_is_regular_up_to_the_delay_limit_of_the_servo_and_not_beyond() {
    let each_joint = "controller.nominal_inertia=diagonal";
    let critical = |settings: &[&str]| {
        let loops = controller::stability::loops(&common::scene("walk", settings)).expect("the paper's robot");
        loops.iter().map(|servo| servo.critical_delay()).fold(f64::INFINITY, f64::min)
    };
    assert!(critical(&[]) > 2.0 * critical(&[each_joint]), "{} and {}", critical(&[]), critical(&[each_joint]));
    let critical = critical(&[each_joint]);
    let folder = fresh_path("robustness");
    let delays = format!("{},{}", critical.floor(), critical.ceil());
    let [table, _] = sweep(
        &["--set", "duration=14", "--set", each_joint, "--delay", &delays, "--jitter", "0", "--loss", "0"],
        &folder,
    );
    let deviations: Vec<f64> = table
        .lines()
        .skip(2)
        .map(|row| row.split(',').nth(11).and_then(|cell| cell.parse().ok()).unwrap_or(f64::INFINITY))
        .collect();
    assert!(
        deviations[0] < 3.0 && deviations[1] > 3.0 * deviations[0],
        "period of two steps varies by {deviations:?} ms at {delays} ms"
    );
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_bad_link_has_the_same_effect_in_one_process_and_in_two_and_duplicates_have_none() {
    let bad =
        ["delay_ms=2", "jitter_ms=3", "loss=0.3", "duplicate=0.3", "reorder=0.3"].map(|key| format!("link.{key}"));
    let with = |settings: &[&'static str]| -> Vec<&str> { [&["duration=3"], settings].concat() };
    let bad: Vec<&str> = bad.iter().map(String::as_str).chain(["duration=3"]).collect();
    let (one, two) = (common::run("walk", &bad), common::run_two("walk", &bad));
    assert_eq!(one.hash(), two.hash());
    let good = common::run("walk", &with(&[]));
    assert_ne!(good.hash(), one.hash());
    assert_eq!(good.hash(), common::run("walk", &with(&["link.duplicate=0.5"])).hash());
    assert_eq!(good.hash(), common::run("walk", &with(&["link.seed=7"])).hash());
    assert_ne!(good.hash(), common::run("walk", &with(&["link.reorder=0.01"])).hash());
}

#[test]
fn other_values_of_a_key_give_a_separate_map() {
    let folder = fresh_path("robustness");
    let [table, map] = sweep(
        &["--delay", "0", "--jitter", "0", "--loss", "0", "--with", "plant.push_impulse=[0,1,0],[0,9,0]"],
        &folder,
    );
    let rows: Vec<&str> = table.lines().skip(2).collect();
    assert!(rows[0].starts_with("0,\"plant.push_impulse=[0,1,0]\",0,0,") && rows[0].contains(",up,"), "{table}");
    assert!(rows[1].starts_with("1,\"plant.push_impulse=[0,9,0]\",0,0,") && rows[1].contains(",fell,"), "{table}");
    assert!(map.contains("[0,9,0]"), "{map}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn an_interrupted_sweep_keeps_its_finished_runs() {
    let folder = fresh_path("robustness");
    let child = biped(&["--seeds", "500", "--out"])
        .arg(&folder)
        .stderr(Stdio::piped())
        .stdout(Stdio::null())
        .spawn()
        .expect("the program starts");
    let path = folder.join("robustness.csv");
    let start = Instant::now();
    while read(&path).lines().count() < 5 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    kill(Pid::from_raw(child.id() as i32), Signal::SIGINT).expect("it is there");
    let output = child.wait_with_output();
    assert_refused(&output.expect("it ends"), 130, &["of 8000 runs are in"]);
    let table = read(&path);
    assert!(table.ends_with('\n') && table.lines().count() >= 5);
    let numbers: Vec<usize> = table.lines().skip(2).filter_map(|row| row.split(',').next()?.parse().ok()).collect();
    assert!(numbers.is_sorted() && numbers.len() == table.lines().count() - 2);
    let files = std::fs::read_dir(&folder).expect("a folder").count();
    assert_eq!(files, 1, "no drafts, and no map of a part");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_bad_argument_is_refused_in_one_sentence() {
    let folder = fresh_path("robustness");
    let refused: [(&[&str], &[&str]); 12] = [
        (&["--delay", "3,1"], &["--delay", "3 comes before 1", "ascend"]),
        (&["--jitter", "1,1"], &["--jitter", "ascend"]),
        (&["--delay", "-1"], &["link.delay_ms = -1", "between 0 and 1000"]),
        (&["--delay=nan"], &["link.delay_ms", "finite"]),
        (&["--loss", "0,1.5"], &["link.loss = 1.5", "between 0 and 1"]),
        (&["--with", "friction"], &["--with friction", "plant.friction=0.7,0.3"]),
        (&["--with", "plant.fricton=0.3"], &["`fricton`", "`friction`"]),
        (&["--set", "plant.dt=0"], &["plant.dt", "greater than 0"]),
        (&["wlak"], &["wlak", "walk"]),
        (&["drop"], &["drop has no controller"]),
        (&["--merge", "/dev/null/none.csv"], &["/dev/null/none.csv cannot be read"]),
        (&["--merge", "README.md"], &["README.md is the table of another sweep"]),
    ];
    common::assert_all_refused(|arguments| output(arguments, &folder), &refused);
    let misused: [(&[&str], &str); 3] =
        [(&["--shard", "5/4"], "i from 1 to n"), (&["--seeds", "0"], "from 1 to 1000"), (&["--loss", "x"], "x")];
    common::assert_all_misused(|arguments| output(arguments, &folder), &misused);
    let unwritable = output(&[], Path::new("/dev/null/robustness"));
    assert_refused(&unwritable, 4, &["/dev/null/robustness cannot be written"]);
    let _ = std::fs::remove_dir_all(folder);
}
