//! A busy machine: plant and controller must not wait for a time slice of another program at every message.

use super::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Programs that compute all the time, for each processor.
const BUSY: usize = 8;
/// Walks of each kind.
const ROUNDS: usize = 9;

/// Wall-clock time of a walk, and the line of its summary that has the hash of all states.
fn walk(kind: &[&str]) -> (Duration, String) {
    let start = Instant::now();
    let arguments = [&["run", "walk", "--quiet"], kind].concat();
    let output = biped(&arguments).stdout(Stdio::piped()).output().expect("the program starts");
    let time = start.elapsed();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let summary = String::from_utf8_lossy(&output.stdout);
    (time, summary.lines().find(|line| line.contains("hash")).expect("a hash").to_string())
}

/// Ends the busy programs, also after a panic.
struct StopOnDrop<'a>(&'a AtomicBool);

impl Drop for StopOnDrop<'_> {
    fn drop(&mut self) {
        self.0.store(true, Relaxed);
    }
}

/// Longest time in two processes, over that in one. Two processes need three times the processor time, for 28,000 switches between them.
/// If each message took a time slice of another program, they would take more than 60 times as long.
const MAX_RATIO: f64 = 4.0;

/// Both kinds get about the same share of the processors.
#[test]
fn a_lockstep_walk_keeps_up_with_one_process_on_a_busy_machine() {
    let (processors, over) = (std::thread::available_parallelism().map_or(1, usize::from), AtomicBool::new(false));
    let times = std::thread::scope(|scope| {
        let _over = StopOnDrop(&over);
        for _ in 0..BUSY * processors {
            scope.spawn(|| {
                while !over.load(Relaxed) {
                    std::hint::spin_loop()
                }
            });
        }
        [(); ROUNDS].map(|()| {
            let [(two, hash), (one, same)] = [&[][..], &["--in-process"]].map(walk);
            assert_eq!(hash, same);
            [two, one]
        })
    });
    let [two, one] = [0, 1].map(|kind| {
        let mut sorted = times.map(|pair| pair[kind]);
        sorted.sort();
        sorted[ROUNDS / 2]
    });
    let ratio = two.as_secs_f64() / one.as_secs_f64();
    println!("beside {} programs: {two:.2?} in two processes, {one:.2?} in one: {ratio:.2} times", BUSY * processors);
    assert!(ratio < MAX_RATIO, "two processes take {ratio:.1} times as long as one");
}
