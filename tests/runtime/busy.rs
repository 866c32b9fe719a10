//! A busy machine: a reader that waits must not lose its processor at every look to whoever computes.

use super::*;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// How long a walk in lockstep takes, and how it ends.
fn walk() -> (Duration, Output) {
    let begun = Instant::now();
    let output = biped(&["run", "walk", "--quiet"]).output().expect("the program starts");
    (begun.elapsed(), output)
}

/// If each look gave the processor to a program that computes for a slice of milliseconds, it would take three hundred times as long.
#[test]
fn a_walk_in_lockstep_goes_on_beside_programs_that_compute() {
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
    assert!(times < 40.0, "{times:.0} times as long");
}
