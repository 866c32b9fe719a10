//! Runs of the program, and checks of their summaries.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]
#![allow(dead_code, reason = "each test file uses a part of this")]

use messages::robot::{DriveParameters, Robot, table_1};
use messages::scene::Scene;
use serde_json::Value;
use std::ops::RangeInclusive;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::sync::atomic::{AtomicU32, Ordering::Relaxed};

/// The summary of one run.
pub struct RunSummary {
    name: String,
    json: Value,
}

/// A new path in the system's temporary folder.
pub fn fresh_path(name: &str) -> PathBuf {
    static COUNT: AtomicU32 = AtomicU32::new(0);
    let count = COUNT.fetch_add(1, Relaxed);
    std::env::temp_dir().join(format!("biped-test-{}-{count}-{name}", std::process::id()))
}

/// Runs a scene in one process, with changed values.
pub fn run(scene: &str, settings: &[&str]) -> RunSummary {
    run_as(scene, settings, &["--in-process"])
}

/// Runs a scene in one process with its smallest equivalent model.
pub fn run_smallest(scene: &str, settings: &[&str]) -> RunSummary {
    run_as(scene, settings, &["--in-process", "--smallest"])
}

/// Runs a scene in two processes.
pub fn run_two(scene: &str, settings: &[&str]) -> RunSummary {
    run_as(scene, settings, &[])
}

fn run_as(scene: &str, settings: &[&str], flags: &[&str]) -> RunSummary {
    let (name, folder) = (format!("{scene} {}", settings.join(" ")), fresh_path("run"));
    let output = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["run", scene, "--quiet"])
        .args(flags)
        .args(settings.iter().flat_map(|setting| ["--set", setting]))
        .arg("--out")
        .arg(&folder)
        .stdin(Stdio::null())
        .output()
        .expect("the program starts");
    let errors = String::from_utf8_lossy(&output.stderr);
    let text = std::fs::read_to_string(folder.join("summary.json"));
    let text = text.unwrap_or_else(|_| panic!("{name}: no summary, {}: {errors}", output.status));
    std::fs::remove_dir_all(folder).expect("our own folder");
    let summary = RunSummary { name, json: serde_json::from_str(&text).expect("JSON") };
    let code = if summary.fell() { 7 } else { 0 };
    assert_eq!(output.status.code(), Some(code), "{}: {errors}", summary.name);
    summary
}

/// Runs several cases of a scene in parallel.
pub fn run_all<S: AsRef<str> + Sync>(scene: &str, cases: &[impl AsRef<[S]> + Sync]) -> Vec<RunSummary> {
    let run = |case: &[S]| run(scene, &case.iter().map(AsRef::as_ref).collect::<Vec<_>>());
    std::thread::scope(|scope| {
        let runs: Vec<_> = cases.iter().map(|case| scope.spawn(|| run(case.as_ref()))).collect();
        runs.into_iter().map(|run| run.join().expect("a run that ends in order")).collect()
    })
}

impl RunSummary {
    /// Whether the robot fell.
    pub fn fell(&self) -> bool {
        self.json["fell"].as_bool().expect("yes or no")
    }

    /// A number of the summary; of a list, the largest.
    pub fn number(&self, key: &str) -> f64 {
        let one = |value: &Value| value.as_f64().unwrap_or(f64::NAN);
        match &self.json[key] {
            Value::Array(list) => list.iter().map(one).fold(f64::NEG_INFINITY, f64::max),
            value => one(value),
        }
    }

    /// Asserts the value of a text.
    pub fn assert_text(&self, key: &str, word: &str) {
        assert_eq!(self.json[key].as_str(), Some(word), "{}: {key}", self.name);
    }

    /// Hash of all states.
    pub fn hash(&self) -> &str {
        self.json["trajectory_hash"].as_str().expect("a hash")
    }

    /// Asserts that the robot did not fall and that each number is in its range. A missing number fails the assertion.
    pub fn assert_ranges(&self, claims: &[(&str, RangeInclusive<f64>)]) {
        let fall = self.number("fall_time_s");
        assert!(!self.fell(), "{}: fell at {fall:.2} s", self.name);
        let broken = claims.iter().filter(|(key, range)| !range.contains(&self.number(key)));
        let broken: Vec<_> =
            broken.map(|(key, range)| format!("{key} = {:e}, not {range:?}", self.number(key))).collect();
        assert!(broken.is_empty(), "{}: {}", self.name, broken.join("; "));
    }
}

/// A built-in scene with changed values.
pub fn scene(name: &str, settings: &[&str]) -> Scene {
    let settings: Vec<_> = settings.iter().map(|setting| setting.to_string()).collect();
    messages::load::load(name, &settings, messages::load::SCENES).expect("a good scene")
}

/// A robot file that is removed when dropped.
pub struct RobotFile {
    path: PathBuf,
}

impl RobotFile {
    /// Writes a robot as TOML.
    pub fn new(robot: &Robot) -> RobotFile {
        RobotFile::of("toml", &toml::to_string(robot).expect("TOML"))
    }

    /// Writes a text to a file with this extension.
    pub fn of(kind: &str, text: &str) -> RobotFile {
        let path = fresh_path(&format!("robot.{kind}"));
        std::fs::write(&path, text).expect("a file");
        RobotFile { path }
    }

    /// Path.
    pub fn path(&self) -> &str {
        self.path.to_str().expect("a path of plain letters")
    }

    /// The setting that uses it in a scene.
    pub fn setting(&self) -> String {
        format!("robot={}", self.path())
    }
}

impl Drop for RobotFile {
    fn drop(&mut self) {
        let _ = std::fs::remove_file(&self.path);
    }
}

/// The robot of Table 1 with all lengths scaled by a factor and all masses by its cube.
pub fn similar(length: f64) -> Robot {
    let mut bodies = table_1();
    for body in &mut bodies {
        body.mass *= length.powi(3);
        let joint = body.joint.iter_mut().map(|joint| &mut joint.at);
        for vector in [&mut body.size, &mut body.com].into_iter().chain(&mut body.contacts).chain(joint) {
            *vector = vector.map(|x| length * x);
        }
    }
    Robot { name: format!("Table 1 times {length}"), drives: DriveParameters::default(), bodies }
}

/// The robot of Table 1 with its shanks scaled in length by a factor.
pub fn shanks(length: f64) -> Robot {
    let mut bodies = table_1();
    for (shank, ankle) in [(2, 1), (6, 7)] {
        bodies[shank].size[2] *= length;
        bodies[shank].com[2] *= length;
        bodies[ankle].joint.as_mut().expect("an ankle").at[2] *= length;
    }
    Robot { name: format!("shanks times {length}"), drives: DriveParameters::default(), bodies }
}

/// Checks that the program ended with this exit code and one sentence, which contains all of these words.
pub fn assert_refused(output: &Output, code: i32, words: &[&str]) {
    let sentence = String::from_utf8_lossy(&output.stderr);
    assert_eq!(output.status.code(), Some(code), "{sentence}");
    assert_eq!(sentence.lines().count(), 1, "{sentence}");
    words.iter().for_each(|word| assert!(sentence.contains(word), "`{word}` is not in: {sentence}"));
}

/// Checks that a command refuses each of these arguments with exit code 2 and one sentence, which contains the words beside them.
pub fn assert_all_refused(run: impl Fn(&[&str]) -> Output, refused: &[(&[&str], &[&str])]) {
    for (arguments, words) in refused {
        println!("{}", arguments.join(" "));
        assert_refused(&run(arguments), 2, words);
    }
}

/// As [`assert_all_refused`], for arguments that the argument parser refuses. It adds a line about help.
pub fn assert_all_misused(run: impl Fn(&[&str]) -> Output, misused: &[(&[&str], &str)]) {
    for (arguments, word) in misused {
        let output = run(arguments);
        let sentence = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.code() == Some(2) && sentence.contains(word), "{arguments:?}: {sentence}");
    }
}
