//! Claims about `biped latency`: on any host it measures and writes every quantity, and leaves no files. The tests do not judge times.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use common::fresh_path;
use messages::session::Session;
use nix::sys::signal::{Signal, kill};
use nix::unistd::Pid;
use serde_json::Value;
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

const TRIPS: [&str; 11] = [
    "raw shared memory, spin",
    "futex hand-over",
    "iceoryx2 alone, spin",
    "pub/sub unsealed, spin",
    "pub/sub, spin",
    "pub/sub, hybrid",
    "pub/sub, event",
    "Unix socket, spin",
    "Unix socket, blocking",
    "UDP, spin",
    "UDP, blocking",
];

fn start(arguments: &[&str]) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command.spawn().expect("the program starts")
}

/// Asserts that no session of a process has left files in shared memory.
fn assert_no_session_files(process: u32) {
    for count in 0..50 {
        let session = Session::named(&format!("latency-{process}-{count}")).expect("a good name");
        assert_eq!(session.shm_files(), Vec::<PathBuf>::new());
    }
}

#[test]
fn every_quantity_is_measured_and_written() {
    let folder = fresh_path("latency");
    let child = start(&["latency", "--quick", "--quiet", "--out", &folder.to_string_lossy()]);
    let process = child.id();
    let output = child.wait_with_output().expect("the program ends");
    let output_text = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{output_text}");
    assert_no_session_files(process);
    let text = std::fs::read_to_string(folder.join("latency.json")).expect("the figures");
    let json: Value = serde_json::from_str(&text).expect("JSON");
    let samples = |section: &str, metric: &str| {
        let series = json["series"].as_array().expect("a list");
        let found = series.iter().find(|row| row["section"] == section && row["metric"] == metric);
        let row = found.unwrap_or_else(|| panic!("{section}, {metric} is missing"));
        let ns = ["min_ns", "median_ns", "p99_ns", "p99_9_ns", "max_ns"].map(|key| row[key].as_u64().expect("a time"));
        assert!(ns.is_sorted() && row["mean_ns"].is_f64(), "{row}");
        row["samples"].as_u64().expect("a count")
    };
    for link in TRIPS {
        assert!(samples(link, "round trip") >= 3, "{link}"); // at least one in each round, also on a busy host
    }
    for way in ["spin", "hybrid", "event"] {
        let section = format!("walk in lockstep, {way}");
        for metric in ["round trip", "sensors to command", "command to plant", "plant computes", "whole period"] {
            assert!((10..=999).contains(&samples(&section, metric)), "{section}, {metric}");
        }
    }
    for section in ["1 kHz, no plant", "1 kHz, walk"] {
        for metric in ["wake of the host's floor", "wake", "sensors to command"] {
            assert!(samples(section, metric) > 0, "{section}, {metric}");
        }
    }
    let count = |metric: &str| {
        let counts = json["counts"].as_array().expect("a list");
        let found = counts.iter().find(|row| row["section"] == "1 kHz, walk" && row["metric"] == metric);
        found.unwrap_or_else(|| panic!("{metric} is missing"))["value"].as_f64().expect("a number")
    };
    for metric in [
        "control periods",
        "ended early",
        "periods skipped",
        "answers missed",
        "longest miss [periods]",
        "least success rate over 100",
        "page faults without a disk",
        "page faults with a disk",
        "context switches, voluntary",
        "context switches, others",
    ] {
        assert!(count(metric) >= 0.0, "{metric}");
    }
    assert!((0.0..=1.0).contains(&count("least success rate over 100")));
    let targets = json["targets"].as_array().expect("a list");
    assert_eq!(targets.len(), 4);
    for target in targets {
        let (ratio, limit) = (target["ratio"].as_f64().expect("a ratio"), target["limit"].as_f64().expect("a limit"));
        assert_eq!(target["met"].as_bool(), Some(ratio <= limit), "{target}");
    }
    let steal = json["host"]["steal"].as_f64().expect("a share");
    assert_eq!(json["valid"].as_bool(), Some(steal <= 0.01));
    let page = std::fs::read_to_string(folder.join("latency.html")).expect("a page");
    assert_eq!(page.matches("<svg").count(), 6);
    assert!(!page.contains("{{") && !page.contains("NaN"), "a placeholder was not filled");
    let printed = String::from_utf8_lossy(&output.stdout);
    assert!(TRIPS.iter().all(|link| printed.contains(link)) && printed.contains("target 5.5"), "{printed}");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn an_interrupted_measurement_leaves_no_session_files() {
    let folder = fresh_path("interrupted");
    let child = start(&["latency", "--quick", "--out", &folder.to_string_lossy()]);
    std::thread::sleep(Duration::from_millis(1500));
    let process = child.id();
    kill(Pid::from_raw(process as i32), Signal::SIGINT).expect("a signal to our own child");
    let output = child.wait_with_output().expect("the program ends");
    assert_eq!(output.status.code(), Some(130), "{}", String::from_utf8_lossy(&output.stderr));
    assert_no_session_files(process);
    let _ = std::fs::remove_dir_all(folder);
}
