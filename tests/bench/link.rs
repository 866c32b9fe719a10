//! Measurements with two processes: round trips of a message, and the lockstep walk. The program itself measures them.

use serde_json::Value;
use std::process::{Command, Stdio};

/// Runs the program with an output folder. Returns the file that it wrote there.
fn biped(arguments: &[&str], file: &str) -> Value {
    let folder = std::env::temp_dir().join(format!("biped-bench-{}", std::process::id()));
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).args(["--quiet", "--out"]).arg(&folder).stdout(Stdio::null()).stderr(Stdio::null());
    let status = command.status().expect("the program starts");
    assert!(status.success(), "biped {} ended with {status}", arguments.join(" "));
    let text = std::fs::read_to_string(folder.join(file)).expect("what it wrote");
    std::fs::remove_dir_all(folder).expect("our own folder");
    serde_json::from_str(&text).expect("JSON")
}

/// Prints medians.
pub fn print() {
    let latency = biped(&["latency", "--quick"], "latency.json");
    println!("\ntwo processes, medians [µs] (biped latency --quick)");
    for series in latency["series"].as_array().into_iter().flatten() {
        let [section, metric] = ["section", "metric"].map(|key| series[key].as_str().unwrap_or_default());
        if ["round trip", "whole period"].contains(&metric) {
            let median = series["median_ns"].as_f64().unwrap_or(f64::NAN) * 1e-3;
            println!("{:<52}{median:>9.2}", format!("{section}, {metric}"));
        }
    }
    println!("\nthe walk of 14 s, start of the processes included, simulated time over time taken");
    for (name, flag) in WALKS {
        println!("{name:<52}{:>9.0}", walk(flag));
    }
}

/// The whole walk, and its command line.
pub const WALKS: [(&str, Option<&str>); 2] =
    [("walk, two processes in lockstep", None), ("walk, one process", Some("--in-process"))];

/// Simulated time per real time of one walk, including the start of the processes.
pub fn walk(flag: Option<&str>) -> f64 {
    let summary = biped(&[&["run", "walk"], flag.as_slice()].concat(), "summary.json");
    summary["realtime_factor"].as_f64().unwrap_or(f64::NAN)
}
