//! Claims about faults: a short version of `biped faults`, which documents its requirements for each kind.

use std::path::Path;
use std::process::{Command, Output, Stdio};

#[test]
fn injected_faults_cause_no_hang_no_wrong_result_and_no_leftovers() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(["faults", "--quick"]).stdin(Stdio::null());
    let Output { status, stdout, stderr } = command.output().expect("the program runs");
    let printed = String::from_utf8_lossy(&stdout); // it has the seed that repeats the run
    assert_eq!(status.code(), Some(0), "{printed}\n{}", String::from_utf8_lossy(&stderr));
    for kind in [
        "kill -9 of the plant",
        "kill -9 of the launcher",
        "stopped",
        "/dev/shm",
        "bad commands",
        "second",
        "disk",
        "limit",
    ] {
        assert!(printed.contains(kind), "{printed}");
    }
}

/// A change of the wall clock has no effect: the only reader of that clock is a recording, once, for its start time.
#[test]
fn only_the_recording_uses_a_clock_that_can_be_set() {
    fn search(folder: &Path, found: &mut Vec<String>, files: &mut usize) {
        for entry in std::fs::read_dir(folder).expect("a folder").flatten() {
            let path = entry.path();
            if path.is_dir() {
                search(&path, found, files);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let text = std::fs::read_to_string(&path).expect("a source");
                let is_bad = ["SystemTime", "CLOCK_REALTIME", "CLOCK_TAI"].iter().any(|clock| text.contains(clock));
                found.extend(is_bad.then(|| path.display().to_string()));
                *files += 1;
            }
        }
    }
    let (mut found, mut files) = (vec![], 0);
    for folder in ["messages/src", "plant/src", "controller/src", "launch"] {
        search(&Path::new(env!("CARGO_MANIFEST_DIR")).join(folder), &mut found, &mut files);
    }
    assert!(files > 100, "only {files} sources");
    assert!(found.len() == 1 && found[0].ends_with("launch/records/src/recording/writer.rs"), "{found:?}");
}
