//! `biped study problems`: millions of contact problems, from situations of robots and of loose bodies.
//!
//! A family generates random scenes. Each episode simulates one scene for some steps. The problem of each step is solved again under each
//! law, every fourth time without a warm start. The residual of the impulse is then computed independently of the solver's own report.

mod families;
mod tally;

pub use families::ProblemFamily;
pub use tally::{LAWS, SolverTally, rows};

use controller::Controller;
use fastrand::Rng;
use messages::wire::Torques;
use plant::Plant;
use plant::contact::{Memory, Solver, tangents};
use rayon::prelude::*;
use shared::exit::{Failure, check_interrupt};
use shared::interrupt::{RESULTS_LOST, UnderWay};
use std::sync::atomic::AtomicBool;
use std::time::Instant;
use strum::VariantArray;

/// Least number of episodes of a family.
const EPISODES: usize = 20;
/// Least and greatest number of problems of an episode.
const EPISODE: (usize, usize) = (25, 200);

/// One episode: simulates a scene and solves its problems under each law.
///
/// # Errors
/// If the scene is bad, or on Ctrl-C.
fn episode(family: ProblemFamily, seed: u64, count: usize, stop: &AtomicBool) -> Result<[SolverTally; 2], Failure> {
    let mut random = Rng::with_seed(seed);
    let (scene, begin) = family.scene(&mut random)?;
    let mut plant = Plant::new(&scene)?.without_standing_feet();
    let controller = scene.controller.as_ref().map(|_| Controller::new(&scene)).transpose();
    let mut controller = controller.map_err(controller::process::ProcessError::from)?;
    let (mut torques, mut encoders) = (Torques::default(), plant.encoders());
    let mut tallies: [SolverTally; 2] = Default::default();
    let mut solver = Solver::default();
    let mut memories: [Memory; 2] = Default::default();
    let mut step = 0;
    let _under_way = UnderWay::begin(RESULTS_LOST);
    while tallies[0].count < count && step < 50_000 {
        check_interrupt(stop)?;
        if let Some(controller) = &mut controller {
            // after a fall the controller may fail; the torques are then zero
            torques = controller.tick(&encoders).unwrap_or_default();
        }
        match plant.advance(&torques) {
            Ok(read) => encoders = read,
            Err(_) => break, // a body that was thrown too fast blows up
        }
        step += 1;
        let problem = plant.problem();
        if step as f64 * scene.plant.dt < begin || problem.contacts == 0 {
            continue;
        }
        for ((law, tally), memory) in LAWS.into_iter().zip(&mut tallies).zip(&mut memories) {
            let narrowed;
            let problem = if tangents(law) == problem.tangents {
                problem
            } else {
                narrowed = problem.narrowed(tangents(law));
                &narrowed
            };
            let is_remembered = random.f64() < 0.75 && *memory != Memory::default();
            if !is_remembered {
                *memory = Memory::default();
            }
            let start = Instant::now();
            let own = solver.solve(problem, law, memory);
            tally.time += start.elapsed().as_secs_f64();
            let impulse = solver.impulse.clone();
            let judged = solver.measure_impulse(problem, law, &impulse);
            tally.note(problem, is_remembered, &own, &judged);
        }
    }
    Ok(tallies)
}

/// Solves `count` problems, the same number of each family, on all cores. Calls `report` with the number of problems solved since
/// the last call.
///
/// # Errors
/// As [`episode`].
pub fn solve(count: usize, stop: &AtomicBool, report: impl Fn(u64) + Sync) -> Result<Vec<[SolverTally; 2]>, Failure> {
    let each = count.div_ceil(ProblemFamily::VARIANTS.len());
    let length = (each / EPISODES).clamp(EPISODE.0, EPISODE.1);
    ProblemFamily::VARIANTS
        .iter()
        .map(|&family| {
            let sum = |[a, b]: [SolverTally; 2], [c, d]: [SolverTally; 2]| [a.merge(c), b.merge(d)];
            (0..each.div_ceil(length))
                .into_par_iter()
                .map(|k| {
                    let count = length.min(each - k * length);
                    let tallies = episode(family, k as u64, count, stop)?;
                    report(count as u64);
                    Ok(tallies)
                })
                .try_reduce(Default::default, |a, b| Ok(sum(a, b)))
        })
        .collect()
}
