//! Threads that help a caller with many short tasks: one for each further processor.
//!
//! A control period of a plant takes a few microseconds, and a thread that sleeps needs tens of them to wake up. The helpers therefore
//! busy-wait for a short time before they sleep. Each thread begins with its own range of the tasks, so that their data stay in the cache of
//! one processor. It then takes the remaining tasks of the other ranges. The caller never waits for a helper that has not begun. So a call
//! also ends if no helper runs, as in a process after `fork`.

#![allow(unsafe_code, reason = "the helpers live longer than the tasks that a caller lends them")]
#![deny(clippy::undocumented_unsafe_blocks)]

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicBool, AtomicPtr, AtomicU64, AtomicUsize, Ordering};
use std::sync::{LazyLock, Mutex, TryLockError};
use std::thread::{Builder, Thread, available_parallelism};
use std::time::{Duration, Instant};

/// Time for which a helper busy-waits for the next call: more than most programs need between two calls.
const SPIN: Duration = Duration::from_micros(100);
/// The bit of [`STATE`] that is set while helpers may begin. The bits below it count the helpers at work, those above it the calls.
const OPEN: u64 = 1 << 16;

static STATE: AtomicU64 = AtomicU64::new(0);
/// The tasks of the present call. They are valid while [`STATE`] is open or counts helpers.
static TASKS: AtomicPtr<Tasks<'static>> = AtomicPtr::new(std::ptr::null_mut());
static HELPERS: LazyLock<Vec<Thread>> = LazyLock::new(helpers);
/// Held during a call.
static CALL: Mutex<()> = Mutex::new(());

/// The tasks of a call.
struct Tasks<'a> {
    work: &'a (dyn Fn(usize) + Sync),
    ranges: Vec<Range>,
    panicked: AtomicBool,
}

/// The tasks with which one thread begins, in cache lines of their own.
#[repr(align(128))]
struct Range {
    next: AtomicUsize,
    end: usize,
}

/// Carries out `work` for each number below `count`, on all processors. If another thread is in such a call, this thread works alone.
pub fn for_each(count: usize, work: &(dyn Fn(usize) + Sync)) {
    let _call = match CALL.try_lock() {
        Ok(call) => call,
        Err(TryLockError::Poisoned(call)) => call.into_inner(),
        Err(TryLockError::WouldBlock) => return (0..count).for_each(work),
    };
    let threads = (HELPERS.len() + 1).min(count);
    let range =
        |thread| Range { next: AtomicUsize::new(count * thread / threads), end: count * (thread + 1) / threads };
    let tasks = Tasks { work, ranges: (0..threads).map(range).collect(), panicked: false.into() };
    TASKS.store((&raw const tasks).cast_mut().cast(), Ordering::Relaxed);
    let open = Open::new();
    HELPERS.iter().take(threads.saturating_sub(1)).for_each(Thread::unpark);
    tasks.carry_out(0);
    drop(open);
    assert!(!tasks.panicked.into_inner(), "a helper panicked");
}

/// Helpers may begin as long as this value exists. Dropping it waits for those that have begun, also after a panic.
struct Open;

impl Open {
    fn new() -> Open {
        let calls = STATE.load(Ordering::Relaxed) / (2 * OPEN);
        STATE.store((calls + 1) * 2 * OPEN + OPEN, Ordering::Release);
        Open
    }
}

impl Drop for Open {
    fn drop(&mut self) {
        STATE.fetch_and(!OPEN, Ordering::Relaxed);
        let start = Instant::now();
        while !STATE.load(Ordering::Acquire).is_multiple_of(OPEN) {
            match start.elapsed() < SPIN {
                true => std::hint::spin_loop(),
                false => std::thread::yield_now(), // a helper has lost its processor
            }
        }
    }
}

impl Tasks<'_> {
    fn carry_out(&self, own: usize) {
        let (before, after) = self.ranges.split_at(own.min(self.ranges.len()));
        for range in after.iter().chain(before) {
            loop {
                let task = range.next.fetch_add(1, Ordering::Relaxed);
                if task >= range.end {
                    break;
                }
                (self.work)(task);
            }
        }
    }
}

/// Starts the helpers.
fn helpers() -> Vec<Thread> {
    let processors = available_parallelism().map_or(1, usize::from);
    let helper = |number| Builder::new().name(format!("biped-{number}")).spawn(move || help(number));
    (1..processors).filter_map(|number| helper(number).ok()).map(|handle| handle.thread().clone()).collect()
}

/// The main function of a helper thread.
fn help(number: usize) {
    let mut last = 0;
    loop {
        last = await_call(last);
        let begin = |state: u64| (state / (2 * OPEN) == last && state & OPEN != 0).then_some(state + 1);
        if STATE.fetch_update(Ordering::Acquire, Ordering::Relaxed, begin).is_ok() {
            // SAFETY: `STATE` was open for this call and now counts this helper. So the caller is still in `for_each`, where the tasks live,
            // and `Open` keeps it there until this helper has left.
            let tasks = unsafe { &*TASKS.load(Ordering::Relaxed) };
            let outcome = catch_unwind(AssertUnwindSafe(|| tasks.carry_out(number)));
            tasks.panicked.fetch_or(outcome.is_err(), Ordering::Relaxed);
            STATE.fetch_sub(1, Ordering::Release);
        }
    }
}

/// Waits for an open call other than the last one, and returns its number.
fn await_call(last: u64) -> u64 {
    let mut start = Instant::now();
    loop {
        let state = STATE.load(Ordering::Relaxed);
        if state & OPEN != 0 && state / (2 * OPEN) != last {
            return state / (2 * OPEN);
        }
        match start.elapsed() < SPIN {
            true => std::hint::spin_loop(),
            false => {
                std::thread::park();
                start = Instant::now();
            }
        }
    }
}
