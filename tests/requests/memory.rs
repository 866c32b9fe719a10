//! Claims about the memory of a plant that runs for a long time.

use crate::live::Running;
use messages::port::Action;
use std::time::Duration;

/// Resident memory of a process, private and shared [kB].
fn memory(number: i32) -> [i64; 2] {
    let status = std::fs::read_to_string(format!("/proc/{number}/status")).expect("a line");
    let line =
        |key| status.lines().find_map(|line| line.strip_prefix(key)).expect("a line").trim_end_matches("kB").trim();
    ["RssAnon:", "RssShmem:"].map(|key| line(key).parse().expect("a line"))
}

/// Shared memory is allocated at the start but becomes resident only on first use, which is when a recorder lags further behind than
/// before.
#[test]
fn memory_does_not_grow_by_resets_and_at_most_once_by_a_slow_recorder() {
    let mut walk = Running::start("memory", &["--set", "duration=100000"]);
    let plant = walk.pid("plant");
    let mut resets = |count| {
        for _ in 0..count {
            let run = walk.ask(Action::Reset { seed: None }).stamp.run;
            walk.until("another walk", |truth| truth.stamp.run == run && truth.stamp.seq > 100);
        }
        let fresh = memory(plant);
        std::thread::sleep(Duration::from_millis(500)); // the plant waits for this recorder
        let lagging = memory(plant);
        walk.drain();
        (fresh, lagging)
    };
    let ((fresh, _), (settled, lagged), (_, again)) = (resets(10), resets(10), resets(60));
    println!(
        "private and shared [kB]: {fresh:?}, after a lag {settled:?}, after a second one {lagged:?}, after 60 resets {again:?}"
    );
    assert!(settled[1] > 1000, "negative control: the buffer of 1024 truths is not visible in {settled:?}");
    assert!((0..2).all(|kind| again[kind] - lagged[kind] < 150), "{lagged:?}, {again:?}");
    walk.end();
}
