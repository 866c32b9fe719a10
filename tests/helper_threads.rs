//! Claims about the helper threads of the Python package (`launch/python/src/helper_threads.rs`), whose own crate has no tests in Rust.

#![expect(clippy::expect_used, reason = "a test may panic")]

#[path = "../launch/python/src/helper_threads.rs"]
mod helper_threads;

use helper_threads::for_each;
use std::collections::HashSet;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering::Relaxed};
use std::thread::{ThreadId, available_parallelism, current};
use std::time::{Duration, Instant};

/// The claims share the helpers, so they take turns.
static TURN: Mutex<()> = Mutex::new(());

/// Does `count` tasks that wait for each other, so that no thread can do all of them before another one has begun. Returns the threads.
fn threads_of(count: usize) -> HashSet<ThreadId> {
    let (threads, start) = (Mutex::new(HashSet::new()), Instant::now());
    for_each(count, &|_| {
        threads.lock().expect("no panic").insert(current().id());
        while threads.lock().expect("no panic").len() < 2 && start.elapsed() < Duration::from_secs(1) {
            std::thread::yield_now();
        }
    });
    threads.into_inner().expect("no panic")
}

#[test]
fn every_task_is_done_exactly_once_and_the_helpers_take_part() {
    let _turn = TURN.lock().expect("no panic");
    for count in [0, 1, 2, 3, 7, 64, 1000] {
        for _ in 0..50 {
            let done: Vec<AtomicU32> = (0..count).map(|_| AtomicU32::new(0)).collect();
            for_each(count, &|task| _ = done[task].fetch_add(1, Relaxed));
            assert!(done.iter().all(|times| times.load(Relaxed) == 1), "{count} tasks");
        }
    }
    match available_parallelism().map_or(1, usize::from) {
        1 => println!("NOT CHECKED: one processor has no helpers"),
        _ => assert!(threads_of(64).len() > 1, "no helper took part"),
    }
}

#[test]
fn a_panic_in_any_thread_ends_the_call_and_the_next_call_is_complete() {
    let _turn = TURN.lock().unwrap_or_else(std::sync::PoisonError::into_inner);
    let caller = current().id();
    for in_helper in [false, true] {
        if in_helper && available_parallelism().map_or(1, usize::from) == 1 {
            println!("NOT CHECKED: one processor has no helpers");
            continue;
        }
        let (done, failed, start) = (AtomicUsize::new(0), AtomicBool::new(false), Instant::now());
        let call = catch_unwind(AssertUnwindSafe(|| {
            for_each(64, &|_| {
                let fails = (current().id() != caller) == in_helper;
                failed.fetch_or(fails, Relaxed);
                assert!(!fails, "a task failed");
                // The other thread gets a task before this one takes all of them.
                while !failed.load(Relaxed) && start.elapsed() < Duration::from_secs(10) {
                    std::thread::yield_now();
                }
                done.fetch_add(1, Relaxed);
            });
        }));
        let panic = call.expect_err("the panic is not lost");
        let words = panic.downcast_ref::<&str>().copied().unwrap_or_default();
        assert_eq!(words, if in_helper { "a helper panicked" } else { "a task failed" });
        assert!(done.load(Relaxed) < 64);
        let after = AtomicUsize::new(0);
        for_each(64, &|_| _ = after.fetch_add(1, Relaxed));
        assert_eq!(after.load(Relaxed), 64);
    }
}
