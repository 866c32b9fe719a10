//! Claims about recordings: a replay repeats them bit for bit; a truncated file is readable up to its last intact chunk; and a foreign file is
//! refused with a sentence.

#![expect(clippy::expect_used, clippy::panic, reason = "a test may panic")]

mod common;

#[path = "common/live.rs"]
mod live;

use common::fresh_path;
use hdrhistogram::Histogram;
use live::{Running, biped};
use messages::port::{Action, GaitRequest};
use std::path::{Path, PathBuf};

/// Exit code and both outputs of a command on a recording.
fn on(file: &Path, command: &[&str]) -> (Option<i32>, String) {
    let output =
        biped(&[&command[..1], &[&file.to_string_lossy()], &command[1..]].concat()).output().expect("it starts");
    let printed = [output.stdout, output.stderr].map(|bytes| String::from_utf8_lossy(&bytes).into_owned()).concat();
    assert!(!printed.contains("panicked"), "{command:?} {}: {printed}", file.display());
    (output.status.code(), printed)
}

/// Runs a scene and records it.
fn record(scene: &str, arguments: &[&str]) -> PathBuf {
    let file = fresh_path("run.mcap");
    let name = file.to_string_lossy().into_owned();
    let all = [&["run", scene, "--quiet", "--record", name.as_str()], arguments].concat();
    let output = biped(&all).output().expect("it starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    file
}

/// Asserts that a replay finds no difference. Returns the number of compared messages.
fn assert_equal(file: &Path, command: &[&str]) -> u64 {
    let (code, printed) = on(file, command);
    assert!(code == Some(0) && printed.contains(" 0 differ"), "{code:?}: {printed}");
    let count = printed.split(": ").nth(1).and_then(|printed| printed.split(' ').next());
    count.and_then(|count| count.parse().ok()).unwrap_or_else(|| panic!("no count in {printed}"))
}

#[test]
fn a_replay_repeats_controller_and_plant_bit_for_bit() {
    let quiet: &[&str] = &["--set", "duration=3"];
    let late = [quiet, &["--set", "link.delay_ms=2", "--set", "link.jitter_ms=2", "--set", "link.loss=0.2"]].concat();
    let single = [quiet, &["--in-process", "--set", "plant.encoder_bits=14"]].concat();
    for (arguments, commands) in [(quiet, 3000..=3000), (&late, 1500..=2900), (&single, 3000..=3000)] {
        let file = record("walk", arguments);
        let count = assert_equal(&file, &["replay"]);
        assert!(commands.contains(&count), "{arguments:?}: {count} commands");
        assert_eq!(assert_equal(&file, &["replay", "--plant"]), 3001);
        std::fs::remove_file(file).expect("our own file");
    }
}

#[test]
fn a_refused_run_does_not_touch_an_existing_recording() {
    let file = record("drop", &["--set", "duration=0.1"]);
    let before = std::fs::read(&file).expect("a recording");
    let new = fresh_path("never.mcap");
    let refused = |file: &Path, arguments: &[&str], word: &str| {
        let output = biped(&["run", "--quiet", "--record"]).arg(file).args(arguments).output().expect("it starts");
        let printed = String::from_utf8_lossy(&output.stderr);
        assert!(
            output.status.code() == Some(2) && printed.contains(word),
            "{arguments:?}: {:?}, {printed}",
            output.status
        );
    };
    for file in [&file, &new] {
        refused(file, &["drop", "--set", "plant.law=ConeQp"], "Rk4Impact");
    }
    let other = std::fs::File::open(&file).expect("a recording");
    other.try_lock().expect("nobody else records"); // another run would hold this lock
    refused(&file, &["drop"], "another run is recording");
    assert!(std::fs::read(&file).expect("a recording") == before && !new.exists());
    drop(other);
    assert_eq!(on(&file, &["replay", "--plant"]).0, Some(0));
    std::fs::remove_file(file).expect("our own file");
}

#[test]
fn requests_are_recorded_and_repeated_by_a_replay() {
    let file = fresh_path("pushed.mcap");
    // ten times slower than real time, so that no scheduler delays recorder or controller by a whole period
    let slow = ["--realtime", "--speed", "0.1", "--record", &file.to_string_lossy(), "--set", "duration=0.5"];
    let walk = Running::start("pushed", &slow);
    walk.ask(Action::Push { body: 4, impulse: [0.5, 0.3, 0.0], duration: 0.05 });
    walk.ask(Action::Gait(GaitRequest::Set { period: Some(0.62), speed: None }));
    walk.ask(Action::Reset { seed: Some(5) });
    walk.ask(Action::Push { body: 4, impulse: [-0.5, 0.3, 0.0], duration: 0.05 });
    walk.ask(Action::Gait(GaitRequest::Stop));
    let (code, _, errors) = walk.wait();
    assert_eq!(code, Some(0), "{errors}");
    for (mode, least) in [(&["replay", "--plant"][..], 3), (&["replay"], 2)] {
        let (code, printed) = on(&file, mode);
        let done =
            printed.lines().find_map(|line| line.strip_suffix(" recorded requests repeated")?.parse::<u32>().ok());
        assert!(code == Some(0) && done.is_some_and(|done| done >= least), "{mode:?}: {printed}");
    }
    let (_, printed) = on(&file, &["info"]);
    assert!(printed.contains(" s in 2 runs, the last 0.500 s of 0.500 s, control at"), "{printed}");
    // In addition to the requests by which the helper waited for the control services.
    let folder = fresh_path("served");
    assert_eq!(on(&file, &["convert", "--csv", &folder.to_string_lossy()]).0, Some(0));
    let served = std::fs::read_to_string(folder.join("served.csv")).expect("a table");
    assert!(served.lines().count() > 4 && served.contains("request.impulse[0]"), "{served}");
    std::fs::remove_dir_all(folder).expect("our own folder");
    std::fs::remove_file(file).expect("our own file");
}

#[test]
fn a_killed_recorder_leaves_a_file_that_is_readable_up_to_its_last_chunk() {
    let file = fresh_path("killed.mcap");
    let mut walk = Running::start("killed", &["--record", &file.to_string_lossy(), "--set", "duration=100000"]);
    walk.until("two chunks", |truth| truth.stamp.seq > 5000);
    walk.end();
    let (code, printed) = on(&file, &["info"]);
    assert!(code == Some(0) && printed.contains("cut short"), "{printed}");
    assert!(assert_equal(&file, &["replay"]) > 1000);
    let page = fresh_path("killed.html");
    let (code, printed) = on(&file, &["view", "--out", &page.to_string_lossy()]);
    assert!(code == Some(0) && printed.contains("is cut short"), "{code:?}: {printed}");
    let text = std::fs::read_to_string(&page).expect("a page");
    assert!(text.contains("CUT SHORT after") && text.contains("the recording ends here"));
    std::fs::remove_file(page).expect("our own file");
    std::fs::remove_file(file).expect("our own file");
}

#[test]
fn a_truncated_or_damaged_file_is_read_up_to_the_damage_or_refused() {
    let whole = record("walk", &["--in-process", "--set", "duration=1.5"]);
    let bytes = std::fs::read(&whole).expect("a recording");
    let seed = std::process::id().into();
    println!("seed {seed}");
    let (mut random, mut read) = (fastrand::Rng::with_seed(seed), 0);
    let (damaged, page) = (fresh_path("damaged.mcap"), fresh_path("damaged.html"));
    for trial in 0..60 {
        let mut some = bytes[..if trial % 2 == 0 { random.usize(..bytes.len()) } else { bytes.len() }].to_vec();
        if trial % 3 > 0 && !some.is_empty() {
            let at = random.usize(..some.len());
            some[at] ^= 1 << random.u8(..8);
        }
        std::fs::write(&damaged, some).expect("a file");
        let (code, printed) = on(&damaged, &["info"]);
        assert!(
            matches!(code, Some(0 | 2 | 5)) && printed.contains("damaged.mcap"),
            "trial {trial}: {code:?}: {printed}"
        );
        read += usize::from(code == Some(0));
        if trial % 4 == 0 {
            let (shown, printed) = on(&damaged, &["view", "--out", &page.to_string_lossy()]);
            assert!(
                shown == code || (code, shown) == (Some(0), Some(2)),
                "trial {trial}: {code:?}, {shown:?}: {printed}"
            );
            assert!(printed.contains("damaged.mcap"), "trial {trial}: {printed}");
        }
    }
    assert!(read > 20, "only {read} of 60 could be read");
    [whole, damaged, page].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn a_file_that_is_no_recording_is_refused() {
    let file = fresh_path("no.mcap");
    for text in ["", "hello", "\u{89}MCAP0\r\n"] {
        std::fs::write(&file, text).expect("a file");
        for command in [
            &["info"][..],
            &["replay"],
            &["replay", "--plant"],
            &["convert", "--csv", "/nonexistent"],
            &["convert", "--mcap", "/nonexistent/x"],
            &["view"],
        ] {
            let (code, printed) = on(&file, command);
            assert!(code == Some(2) && printed.contains("no.mcap: this is no recording"), "{code:?}: {printed}");
        }
    }
    std::fs::remove_file(&file).expect("our own file");
    for command in [["info"], ["view"]] {
        let (code, printed) = on(&file, &command);
        assert!(code == Some(2) && printed.contains("cannot be opened"), "{printed}");
    }
    let output = biped(&["run", "walk", "--quiet", "--record", "/nonexistent/run.mcap"]).output().expect("it starts");
    let printed = String::from_utf8_lossy(&output.stderr);
    assert!(
        output.status.code() == Some(4) && printed.contains("/nonexistent/run.mcap cannot be written"),
        "{printed}"
    );
}

#[test]
fn a_recording_is_not_replaced_by_a_table_or_page() {
    let [file, other] = [(); 2].map(|()| record("drop", &["--set", "duration=0.05"]));
    let kept = std::fs::read(&other).expect("a recording");
    let to = other.to_string_lossy().into_owned();
    for command in [&["convert", "--table", &to][..], &["view", "--out", &to]] {
        let (code, printed) = on(&file, command);
        let sentence = format!("error: {to} cannot be written: the file exists and is a recording; it is kept");
        assert!(code == Some(2) && printed.contains(&sentence), "{command:?}: {code:?}, {printed}");
    }
    assert!(std::fs::read(&other).expect("a recording") == kept);
    [file, other].iter().for_each(|file| std::fs::remove_file(file).expect("our own file"));
}

#[test]
fn a_recording_is_not_converted_into_itself() {
    let file = record("slide", &["--in-process", "--set", "duration=0.1"]);
    let folder = fresh_path("itself");
    std::fs::create_dir(&folder).expect("a folder");
    let truth = folder.join("truth.csv"); // named as a table of the folder
    std::fs::copy(&file, &truth).expect("a copy");
    for (input, option, output) in [(&file, "--table", &file), (&file, "--mcap", &file), (&truth, "--csv", &folder)] {
        let (code, printed) = on(input, &["convert", option, &output.to_string_lossy()]);
        assert!(code == Some(2) && printed.contains("is the input file"), "{option}: {code:?}: {printed}");
    }
    std::fs::remove_dir_all(folder).expect("our own folder");
    std::fs::remove_file(file).expect("our own file");
}

#[test]
fn tables_contain_every_message_bit_for_bit() {
    let file = record("walk", &["--in-process", "--set", "duration=0.5"]);
    let folder = fresh_path("tables");
    let (code, printed) = on(&file, &["convert", "--csv", &folder.to_string_lossy()]);
    assert!(code == Some(0) && printed.contains("truth.csv: 501 rows"), "{printed}");
    let table = |name: &str| std::fs::read_to_string(folder.join(name)).expect("a table");
    let rows = |name: &str| table(name).lines().count() - 1;
    assert_eq!(["sensors.csv", "command.csv", "telemetry.csv"].map(rows), [501, 500, 500]);
    let truth = table("truth.csv");
    let mut lines = truth.lines().map(|line| line.split(',').collect::<Vec<_>>());
    let head = lines.next().expect("names");
    let hash = head.iter().position(|name| *name == "hash").expect("the hash");
    let last = lines.next_back().expect("a row");
    assert_eq!((last.len(), last[0]), (head.len(), "0.500000000"));
    let summary = common::run("walk", &["duration=0.5"]);
    assert_eq!(format!("{:016x}", last[hash].parse::<u64>().expect("a number")), summary.hash());
    std::fs::remove_file(file).and_then(|()| std::fs::remove_dir_all(folder)).expect("our own files");
}

/// Histograms of three times in a control period: wake-up latency, computing time of the plant, response time of the controller [ns].
type Loop = [Histogram<u64>; 3];
const PARTS: [&str; 3] = ["wakes late by", "plant computes", "answer takes"];

/// Adds a real-time walk of some seconds to the histograms.
fn measure(counted: &mut Loop, seconds: u64, arguments: &[&str]) {
    let duration = format!("duration={seconds}");
    let mut walk = Running::start("paced", &[&["--realtime", "--set", &duration], arguments].concat());
    walk.until_exit(|truth| {
        let times = [truth.late_ns, truth.plant_ns, truth.reply_ns];
        counted.iter_mut().zip(times).for_each(|(counted, time)| counted.saturating_record(time));
    });
    if let (Some(code @ 1..), _, errors) = walk.wait() {
        println!("ended early, by {code}: {errors}"); // the host was too busy for a control loop
    }
}

/// `cargo test --release --test recording histogram -- --ignored --nocapture`, on an idle machine. Walks with
/// and without a recorder alternate. Half of those without are a second group, which shows the variation without any cause.
#[test]
#[ignore = "two minutes; prints the paced loop's histogram with and without a recorder"]
fn the_histogram_of_the_loop_is_the_same_with_and_without_a_recorder() {
    let file = fresh_path("paced.mcap");
    let record = ["--record", &file.to_string_lossy()];
    let empty = || [(); 3].map(|()| Histogram::new_with_bounds(1, 1_000_000_000, 3).expect("good bounds"));
    let mut counted = [empty(), empty(), empty()];
    for round in 0..8 {
        for arm in [[0, 1, 2], [2, 1, 0]][round % 2] {
            measure(&mut counted[arm], 5, if arm == 1 { &record } else { &[] });
        }
    }
    std::fs::remove_file(&file).expect("our own file");
    for (arm, what) in counted.iter().zip(["without a recorder", "with one", "without, again"]) {
        for (part, counted) in PARTS.iter().zip(arm) {
            let [median, p99] = [0.5, 0.99].map(|share| counted.value_at_quantile(share) as f64 * 1e-3);
            println!("{what:<19} {part:<15} median {median:>7.1} us, p99 {p99:>7.1} us, {} periods", counted.len());
        }
    }
    let ratio = |above: usize, part: usize, share| {
        counted[above][part].value_at_quantile(share) as f64 / counted[0][part].value_at_quantile(share) as f64
    };
    for (part, name) in PARTS.iter().enumerate() {
        let [with, again] = [1, 2].map(|arm| [0.5, 0.99].map(|share| ratio(arm, part, share)));
        println!(
            "{name:<15} with : without = {:.3} in the median, {:.3} in p99; without : without = {:.3}, {:.3}",
            with[0], with[1], again[0], again[1]
        );
        assert!((0.8..1.25).contains(&with[0]), "{name}: {} times the median", with[0]);
    }
}
