//! Claims about files: no command replaces or removes a foreign file, and none blocks on an endless input.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

#[path = "common/live.rs"]
mod live;

use common::fresh_path;
use live::biped;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Runs a command in a folder. Returns its exit code and standard error.
fn within(folder: &Path, command: &str) -> (Option<i32>, String) {
    let output = biped(&command.split(' ').collect::<Vec<_>>()).current_dir(folder).output().expect("it starts");
    (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
}

/// All files below a folder, with their contents.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("a folder").flatten().map(|entry| entry.path());
    let each = entries.flat_map(|path| match path.is_dir() {
        true => files(&path),
        false => BTreeMap::from([(path.clone(), std::fs::read(&path).expect("a file"))]),
    });
    each.collect()
}

/// Commands that write files, with short runs, and the files that each of them writes.
const WRITERS: [(&str, &[&str]); 10] = [
    (
        "run stand --in-process --quiet --set duration=0.1 --out out",
        &["out/summary.json", "out/trajectory.csv", "out/report.html", "out/scene.toml"],
    ),
    ("run stand --in-process --quiet --set duration=0.1 --record new.mcap", &["new.mcap"]),
    ("view run.mcap --out view.html", &["view.html"]),
    ("view run.mcap --out page", &["page"]),
    ("convert run.mcap --csv tables", &["tables/truth.csv", "tables/sensors.csv"]),
    ("convert run.mcap --table table.csv", &["table.csv"]),
    ("convert run.mcap --mcap copy.mcap", &["copy.mcap"]),
    ("study problems --count 2 --quiet --out study", &["study/problems.md", "study/problems.csv"]),
    (
        "robustness --quiet --loss 0 --delay 0 --jitter 0 --seeds 1 --set duration=0.1 --out map",
        &["map/robustness.csv", "map/robustness.svg"],
    ),
    ("faults --quick --only second --seed 1 --out faults", &["faults/faults.md", "faults/faults.csv"]),
];

#[test]
fn foreign_files_survive_every_command_and_files_of_this_program_are_replaced() {
    let folder = fresh_path("kept");
    std::fs::create_dir(&folder).expect("a folder");
    let record = "run stand --in-process --quiet --set duration=0.1 --record run.mcap";
    assert_eq!(within(&folder, record).0, Some(0));
    for (command, outputs) in WRITERS {
        // foreign files beside the outputs, with names that temporary files and figures could have
        let mut theirs = BTreeMap::new();
        for output in outputs {
            let output = folder.join(output);
            let beside = output.parent().expect("a folder");
            std::fs::create_dir_all(beside.join("figures")).expect("a folder");
            for path in [output.with_extension("part"), beside.join("figures/mine.svg"), beside.join("mine.csv")] {
                std::fs::write(&path, "mine").expect("a file");
                theirs.insert(path, b"mine".to_vec());
            }
        }
        let survives = |printed: &str| {
            let now = files(&folder);
            theirs.iter().for_each(|(path, text)| assert_eq!(now.get(path), Some(text), "{command}: {printed}"));
        };
        for _ in 0..2 {
            let (code, printed) = within(&folder, command); // the second call replaces the files of the first
            assert_eq!(code, Some(0), "{command}: {printed}");
            survives(&printed);
        }
        let is_temporary =
            |path: &PathBuf| path.file_name().is_some_and(|name| name.to_string_lossy().starts_with('.'));
        assert!(!files(&folder).keys().any(is_temporary), "{command} leaves a temporary file");
        for output in outputs.iter().map(|output| folder.join(output)) {
            assert!(output.exists(), "{command} writes {}", output.display());
            std::fs::write(&output, "<!DOCTYPE html>\nmine alone").expect("a file");
            let (code, printed) = within(&folder, command);
            let name = output.file_name().expect("a name").to_string_lossy();
            assert!(matches!(code, Some(2 | 4)) && printed.contains(&*name), "{command}, {name}: {code:?} {printed}");
            assert_eq!(std::fs::read(&output).expect("a file"), b"<!DOCTYPE html>\nmine alone", "{command}: {printed}");
            survives(&printed);
            std::fs::remove_file(&output).expect("our own file");
        }
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn a_folder_for_results_that_is_something_else_is_refused_as_such() {
    let folder = fresh_path("no-folder");
    std::fs::create_dir(&folder).expect("a folder");
    std::fs::write(folder.join("file"), "mine").expect("a file");
    std::os::unix::fs::symlink("nowhere", folder.join("dangling")).expect("a link");
    std::os::unix::fs::symlink("loop", folder.join("loop")).expect("a link");
    for path in ["file", "dangling", "loop"] {
        for command in ["run stand --in-process --quiet --out", "study laws --out", "chart --out"] {
            let (code, printed) = within(&folder, &format!("{command} {path}"));
            let sentence = format!("error: {path} is not a folder: choose another path\n");
            assert_eq!((code, printed), (Some(2), sentence), "{command} {path}");
        }
    }
    assert_eq!(std::fs::read(folder.join("file")).expect("a file"), b"mine");
    std::fs::remove_dir_all(folder).expect("our own folder");
}

#[test]
fn pipes_devices_and_folders_are_refused_by_every_reading_command() {
    let folder = fresh_path("endless");
    std::fs::create_dir(&folder).expect("a folder");
    nix::unistd::mkfifo(&folder.join("pipe"), nix::sys::stat::Mode::S_IRWXU).expect("a pipe");
    let commands = [
        "run FILE",
        "plant FILE",
        "model FILE",
        "export toml FILE",
        "run walk --robot FILE",
        "run walk --set robot=FILE",
        "contact FILE",
        "info FILE",
        "replay FILE",
        "view FILE",
        "convert FILE --csv x",
        "convert FILE --mcap x.mcap",
        "robustness --merge FILE",
        "sweep walk plant.friction=0.7 --merge FILE",
        "chart --peers=FILE",
    ];
    for (file, what) in [("pipe", "pipe"), ("/dev/zero", "device"), (".", "folder")] {
        for command in commands {
            let (code, printed) = within(&folder, &command.replace("FILE", file));
            assert!(code == Some(2) && printed.contains(what), "{command} {file}: {code:?} {printed}");
        }
    }
    for command in ["run walk --record pipe", "view run.mcap --out pipe"] {
        let (code, printed) = within(&folder, command);
        assert!(code == Some(2) && !printed.is_empty(), "{command}: {code:?} {printed}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
}
