//! A busy machine: a waiting reader must not lose its processor to other programs at every poll.

use super::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Wall-clock time and output of a lockstep walk.
fn walk() -> (Duration, Output) {
    let start = Instant::now();
    let output = biped(&["run", "walk", "--quiet"]).output().expect("the program starts");
    (start.elapsed(), output)
}

/// If every poll gave the processor to another program for a time slice of milliseconds, the walk would take 300 times as long.
#[test]
fn a_lockstep_walk_keeps_its_bits_and_progress_on_a_busy_machine() {
    let (alone, over) = (walk(), AtomicBool::new(false));
    let processors = std::thread::available_parallelism().map_or(1, usize::from);
    let busy = std::thread::scope(|scope| {
        for _ in 0..processors {
            scope.spawn(|| {
                while !over.load(Relaxed) {
                    std::hint::spin_loop()
                }
            });
        }
        let busy = walk();
        over.store(true, Relaxed);
        busy
    });
    for (_, output) in [&alone, &busy] {
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    let times = busy.0.as_secs_f64() / alone.0.as_secs_f64();
    println!("{:.2?} alone, {:.2?} beside {processors} programs: {times:.1} times", alone.0, busy.0);
    assert!(times < 40.0, "the walk takes {times:.0} times as long");
}
