//! Every contact law on the problems that occur while the robot stands, walks and falls, with a cold start and with a warm start from the previous
//! solution.

use crate::robot::{Activity, Recording};
use divan::Bencher;
use messages::scene::Law;
use plant::contact::{Memory, Solver};
use std::fmt;

/// A law, with or without a warm start.
#[derive(Clone, Copy, Debug)]
struct LawStart(Law, bool);

impl fmt::Display for LawStart {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "{} {}", self.0, if self.1 { "warm" } else { "cold" })
    }
}

fn starts() -> impl Iterator<Item = LawStart> {
    Law::ALL.into_iter().flat_map(|law| [LawStart(law, false), LawStart(law, true)])
}

/// Each sample is one problem; the problems are in the order of the run.
fn solve(bencher: Bencher, activity: Activity, LawStart(law, warm): LawStart) {
    let problems = Recording::of(activity, &[format!("plant.law={law}")]).problems;
    let (mut solver, mut memory, mut turn) = (Solver::default(), Memory::default(), problems.iter().cycle());
    for problem in &problems {
        solver.solve(problem, law, &mut memory);
    }
    bencher.bench_local(|| {
        if !warm {
            memory = Memory::default();
        }
        turn.next().map(|problem| solver.solve(problem, law, &mut memory))
    });
}

#[divan::bench(args = starts(), sample_count = 600, sample_size = 1)]
fn standing(bencher: Bencher, start: &LawStart) {
    solve(bencher, Activity::Standing, *start);
}

#[divan::bench(args = starts(), sample_count = 600, sample_size = 1)]
fn walking(bencher: Bencher, start: &LawStart) {
    solve(bencher, Activity::Walking, *start);
}

#[divan::bench(args = starts(), sample_count = 600, sample_size = 1)]
fn falling(bencher: Bencher, start: &LawStart) {
    solve(bencher, Activity::Tumbling, *start);
}
