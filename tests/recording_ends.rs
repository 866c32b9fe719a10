//! Claims about recordings that end before their run: the run continues, the exit code reports it, and the recording is complete up to its end.
//! Also claims about recordings with inconsistent content.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

#[path = "common/live.rs"]
mod live;

use common::fresh_path;
use live::biped;
use mcap::records::Record;
use mcap::{McapResult, Writer};
use std::fs::File;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

/// Exit code and both outputs of a command that must not panic.
fn result(output: Output) -> (Option<i32>, String) {
    let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(!printed.contains("panicked"), "{printed}");
    (output.status.code(), printed)
}

fn on(arguments: &[&str]) -> (Option<i32>, String) {
    result(biped(arguments).output().expect("it starts"))
}

/// Records a walk of some seconds in one process, after some shell commands.
fn walk(before: &str, more: &str, file: &Path, out: &Path) -> (Option<i32>, String) {
    let script = format!(
        "{before}\n exec '{}' run walk --in-process --quiet --set duration=8 {more} --record '{}' --out '{}'",
        env!("CARGO_BIN_EXE_biped"),
        file.display(),
        out.display()
    );
    result(Command::new("sh").args(["-c", &script]).output().expect("a shell"))
}

fn summary(out: &Path) -> serde_json::Value {
    serde_json::from_slice(&std::fs::read(out.join("summary.json")).expect("a summary")).expect("JSON")
}

/// Asserts that a recording replays without a difference. Returns its length [bytes].
fn assert_replays(file: &Path) -> u64 {
    let (code, printed) = on(&["replay", &file.to_string_lossy()]);
    assert!(code == Some(0) && printed.contains(" 0 differ"), "{code:?}: {printed}");
    file.metadata().expect("a file").len()
}

#[test]
fn a_recording_ends_at_its_limit_and_the_run_continues() {
    let (file, out) = (fresh_path("end.mcap"), fresh_path("end"));
    let clean = |file: &Path| std::fs::remove_dir_all(&out).and_then(|()| std::fs::remove_file(file)).expect("our own");
    let (code, printed) = walk("", "", &file, &out);
    assert_eq!(code, Some(0), "{printed}");
    let (whole, hash) = (assert_replays(&file), summary(&out)["trajectory_hash"].clone());
    assert!(summary(&out)["recording_ended_by"].is_null() && !printed.contains("the recording"), "{printed}");
    clean(&file);
    // a limit by option, and one by the system
    for (before, more, ends, limit, why) in [
        ("", "--record-limit 5M", 0, 5_000_000, "--record-limit of 5 MB is reached"),
        ("ulimit -f 8000", "", 11, 4_096_000, "File too large"),
    ] {
        let (code, printed) = walk(before, more, &file, &out);
        assert!(
            code == Some(ends) && printed.contains(why) && printed.contains("the run continues"),
            "{code:?}: {printed}"
        );
        let summary = summary(&out);
        let end = summary["recording_ended_by"].as_str().expect("a sentence");
        assert!(end.contains(why) && summary["trajectory_hash"] == hash && summary["fell"] == false, "{end}");
        let report = std::fs::read_to_string(out.join("report.html")).expect("a report");
        assert!(report.contains(why), "the report says it");
        let length = assert_replays(&file);
        assert!((limit / 3..=limit).contains(&length) && length < whole, "{length} of {whole} bytes, limit {limit}");
        let (_, printed) = on(&["info", &file.to_string_lossy()]);
        assert_eq!(printed.contains("cut short"), ends != 0, "one that was ended in order has its index: {printed}");
        clean(&file);
    }
    let (code, printed) = walk("", "", Path::new("/dev/full"), &out);
    assert!(
        code == Some(11) && printed.contains("No space left") && summary(&out)["trajectory_hash"] == hash,
        "{printed}"
    );
    std::fs::remove_dir_all(&out).expect("our own");
}

/// The plant goes on until its launcher stops it, some random time after the end of the analysis.
#[test]
fn the_recording_of_a_fall_ends_with_its_summary_in_two_processes_too() {
    let (file, out) = (fresh_path("fall.mcap"), fresh_path("fall"));
    let [name, folder] = [&file, &out].map(|path| path.to_string_lossy().into_owned());
    let push = ["--set", "plant.push_impulse=[0,6,0]", "--set", "plant.push_time=0.5", "--set", "duration=6"];
    let run = [&["run", "walk", "--quiet", "--record", &name, "--out", &folder], &push[..]].concat();
    for processes in [&["--in-process"][..], &[], &[]] {
        let (code, printed) = on(&[&run[..], processes].concat());
        assert_eq!(code, Some(7), "{printed}");
        let summary = summary(&out);
        let end = format!("{:.3} s of 6.000 s", summary["duration_s"].as_f64().expect("a time"));
        let hash = summary["trajectory_hash"].as_str().expect("a hash");
        let (_, printed) = on(&["info", &name]);
        assert!(printed.contains(&end) && printed.contains(hash), "{end}, {hash}, {processes:?}: {printed}");
    }
    std::fs::remove_dir_all(out).and_then(|()| std::fs::remove_file(file)).expect("our own");
}

#[test]
fn a_limit_must_be_a_size_and_a_full_disk_is_reported_before_the_run() {
    for bad in ["5", "3M", "fast", "nanG", "1Q", "infM"] {
        let (code, printed) = on(&["run", "walk", "--record", "x.mcap", "--record-limit", bad]);
        assert!(code == Some(2) && printed.contains("200M or 1.5G"), "{bad}: {printed}");
    }
    assert_eq!(on(&["run", "walk", "--record-limit", "200M"]).0, Some(2), "a limit of nothing");
    let file = fresh_path("long.mcap");
    let name = file.to_string_lossy().into_owned();
    let push = "plant.push_impulse=[0,200,0] --set plant.push_time=0.1";
    let long = format!("run walk --in-process --quiet --set duration=1e9 --set {push} --record");
    let long: Vec<&str> = long.split(' ').collect();
    let (code, printed) = on(&[&long[..], &[&name]].concat());
    assert!(code == Some(7) && printed.contains("the run will take some 95"), "{code:?}: {printed}");
    let (_, printed) = on(&[&long[..], &[&name, "--record-limit", "8M"]].concat());
    assert!(!printed.contains("will take"), "{printed}");
    std::fs::remove_file(file).expect("our own file");
}

/// Records a short walk and writes the file again with changed records.
fn forged(name: &str, mut change: impl FnMut(&mut Record)) -> PathBuf {
    let (file, forged) = (fresh_path("true.mcap"), fresh_path(name));
    let (code, printed) =
        on(&["run", "walk", "--in-process", "--quiet", "--set", "duration=0.1", "--record", &file.to_string_lossy()]);
    assert_eq!(code, Some(0), "{printed}");
    let bytes = std::fs::read(&file).expect("a recording");
    let mut writer = Writer::new(File::create(&forged).expect("a file")).expect("it begins");
    for record in mcap::read::ChunkFlattener::new(&bytes).expect("MCAP") {
        let mut record = record.expect("a record").into_owned();
        change(&mut record);
        copy(&mut writer, &record).expect("it is written");
    }
    writer.finish().expect("it ends");
    std::fs::remove_file(file).expect("our own file");
    forged
}

fn copy(writer: &mut Writer<File>, record: &Record) -> McapResult<()> {
    match record {
        Record::Metadata(metadata) => writer.write_metadata(metadata),
        Record::Schema { header, data } => {
            writer.add_schema_with_id(header.id, &header.name, &header.encoding, data).map(drop)
        }
        Record::Channel(channel) => {
            let mcap::records::Channel { id, schema_id, topic, message_encoding, metadata } = channel;
            writer.add_channel_with_id(*id, *schema_id, topic, message_encoding, metadata).map(drop)
        }
        Record::Message { header, data } => writer.write_to_known_channel(header, data),
        _ => Ok(()),
    }
}

/// All commands that open a recording. Some of them write to a path that begins with TO.
fn commands(file: &Path, to: &Path) -> [Vec<String>; 8] {
    let all = [
        "info FILE",
        "info FILE --scene",
        "replay FILE",
        "replay FILE --plant",
        "view FILE --out TO.html",
        "convert FILE --csv TO",
        "convert FILE --table TO.csv",
        "convert FILE --mcap TO.mcap",
    ];
    let named = |word: &str| word.replace("FILE", &file.to_string_lossy()).replace("TO", &to.to_string_lossy());
    all.map(|command| command.split(' ').map(named).collect())
}

fn clean(to: &Path) {
    let _ = std::fs::remove_dir_all(to);
    for end in ["html", "csv", "mcap"] {
        let _ = std::fs::remove_file(to.with_extension(end));
    }
}

#[test]
fn the_scene_in_a_recording_is_checked_like_any_other() {
    for (from, to, word) in [
        ("mass = ", "mass = nan #", "finite"),
        ("mass = ", "mass = 0.0 #", "greater than 0"),
        ("duration = ", "duration = -1.0 #", "greater than 0"),
        ("rate = 1000.0", "rate = 1e-300", "plant.dt"),
        ("friction", "frixion", "frixion"),
    ] {
        let file = forged("scene.mcap", |record| {
            if let Record::Metadata(about) = record {
                let scene = about.metadata.get_mut("scene").expect("a scene");
                assert!(scene.contains(from));
                *scene = scene.replacen(from, to, 1);
            }
        });
        let place = fresh_path("forged");
        for command in commands(&file, &place) {
            let printed: Vec<&str> = command.iter().map(String::as_str).collect();
            let (code, said) = on(&printed);
            assert!(
                code == Some(2) && said.contains("the scene in") && said.contains(word),
                "{command:?}: {code:?} {said}"
            );
        }
        assert!(!place.exists(), "a refused command creates no folder");
        std::fs::remove_file(file).expect("our own file");
    }
}

#[test]
fn inconsistent_messages_are_read_or_refused_without_a_panic() {
    let seed = std::process::id().into();
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for trial in 0..12 {
        let file = forged("lies.mcap", |record| {
            if let Record::Message { header, data } = record
                && random.u8(..) < 100
            {
                let at = random.usize(..data.len());
                let value =
                    *random.choice(&[u64::MAX, 1 << 63, f64::NAN.to_bits(), f64::MAX.to_bits(), 0]).expect("one");
                let target = &mut data.to_mut()[at..];
                let length = target.len().min(8);
                target[..length].copy_from_slice(&value.to_le_bytes()[..length]);
                header.log_time = if random.u8(..) < 9 { u64::MAX } else { header.log_time };
            }
        });
        let place = fresh_path("lies");
        for command in commands(&file, &place) {
            let printed: Vec<&str> = command.iter().map(String::as_str).collect();
            let (code, said) = on(&printed);
            assert!(matches!(code, Some(0 | 2 | 4 | 7 | 8)), "trial {trial}: {command:?}: {code:?} {said}");
        }
        clean(&place);
        std::fs::remove_file(file).expect("our own file");
    }
}
