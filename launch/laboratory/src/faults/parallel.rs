//! Parallel trials, for those that mostly wait.

use super::memory;
use super::test_session::FaultTrial;
use shared::progress::BatchProgress;
use shared::thread;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering::Relaxed};

/// Number of parallel trials.
const WORKERS: usize = 4;

/// Runs trials that mostly wait, [`WORKERS`] in parallel. Each worker has its own shared memory. If the system does not permit this, the
/// trials run one after the other.
pub fn in_parallel(
    count: usize,
    random: &mut fastrand::Rng,
    quiet: bool,
    stop: &AtomicBool,
    trial: &(dyn Fn(usize, &mut fastrand::Rng) -> FaultTrial + Sync),
) -> Vec<FaultTrial> {
    let progress = BatchProgress::new(quiet, count, 0, "trials");
    let next = AtomicUsize::new(0);
    let seeds: Vec<u64> = (0..count).map(|_| random.u64(..)).collect();
    let work = &|first: bool| {
        let mut outcomes: Vec<(usize, FaultTrial)> = vec![];
        // the first worker may use the common shared memory
        if memory::of_ones_own().is_err() && !first {
            return outcomes;
        }
        while !stop.load(Relaxed)
            && let nth = next.fetch_add(1, Relaxed)
            && nth < count
        {
            outcomes.push((nth, trial(nth, &mut fastrand::Rng::with_seed(seeds[nth]))));
            progress.add_done(1);
        }
        outcomes
    };
    let mut all = std::thread::scope(|scope| {
        let start = |nth| thread::start_scoped(scope, move || work(nth == 0));
        let workers: Vec<_> = (0..WORKERS.min(count)).map(start).collect();
        let failed = |why: String| vec![(count, Err(why))];
        let outcomes = workers.into_iter().flat_map(|worker| match worker {
            Ok(worker) => worker.join().unwrap_or_else(|_| failed("the thread of the trials failed".into())),
            Err(failure) => failed(failure.message),
        });
        outcomes.collect::<Vec<_>>()
    });
    progress.finish();
    all.sort_by_key(|(nth, _)| *nth);
    all.into_iter().map(|(_, outcomes)| outcomes).collect()
}
