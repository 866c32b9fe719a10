//! `biped study problems`: contact problems by the million, from whatever a robot or a heap of bodies can get into.
//!
//! A family is a way to make scenes by chance. Each of its episodes is one scene, simulated for some steps; the problem
//! of each step is solved again under each law, every fourth time without the basis of the last step. The impulse is
//! then judged afresh: what a solver says of itself counts for nothing.

mod families;
mod tally;

pub use families::Family;
pub use tally::{Tally, rows};

use controller::Controller;
use fastrand::Rng;
use messages::scene::Law;
use messages::wire::Torques;
use plant::Plant;
use plant::contact::{Memory, Solver, tangents};
use rayon::prelude::*;
use shared::exit::{Failure, check_interrupt};
use std::sync::atomic::AtomicBool;
use std::time::Instant;

/// Laws that are asked.
pub const LAWS: [Law; 2] = [Law::Cone, Law::Aligned];
/// Episodes of a family at least.
const EPISODES: usize = 20;
/// Problems of one episode.
const EPISODE: (usize, usize) = (25, 200);

/// One episode: simulates a scene and solves its problems under each law.
///
/// # Errors
/// If the scene is bad, or on Ctrl-C.
fn episode(family: Family, seed: u64, count: usize, stop: &AtomicBool) -> Result<[Tally; 2], Failure> {
    let mut random = Rng::with_seed(seed);
    let (scene, begin) = family.scene(&mut random)?;
    let mut plant = Plant::new(&scene)?.without_welds();
    let controller = scene.controller.as_ref().map(|_| Controller::new(&scene)).transpose();
    let mut controller = controller.map_err(controller::process::ProcessError::from)?;
    let (mut torques, mut encoders) = (Torques::default(), plant.encoders());
    let mut tallies: [Tally; 2] = Default::default();
    let mut solver = Solver::default();
    let mut memories: [Memory; 2] = Default::default();
    let mut step = 0;
    while tallies[0].count < count && step < 50_000 {
        check_interrupt(stop)?;
        if let Some(controller) = &mut controller {
            // A controller that gives up after a fall leaves the joints to themselves.
            torques = controller.tick(&encoders).unwrap_or_default();
        }
        match plant.advance(&torques) {
            Ok(read) => encoders = read,
            Err(_) => break, // what was thrown too hard blows up
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

/// Solves `count` problems, as many of each family, on all cores; `told` hears how many more are done.
///
/// # Errors
/// As [`episode`].
pub fn solve(count: usize, stop: &AtomicBool, told: impl Fn(u64) + Sync) -> Result<Vec<[Tally; 2]>, Failure> {
    let each = count.div_ceil(Family::ALL.len());
    let length = (each / EPISODES).clamp(EPISODE.0, EPISODE.1);
    Family::ALL
        .iter()
        .map(|&family| {
            let sum = |[a, b]: [Tally; 2], [c, d]: [Tally; 2]| [a.merge(c), b.merge(d)];
            (0..each.div_ceil(length))
                .into_par_iter()
                .map(|k| {
                    let count = length.min(each - k * length);
                    let tallies = episode(family, k as u64, count, stop)?;
                    told(count as u64);
                    Ok(tallies)
                })
                .try_reduce(Default::default, |a, b| Ok(sum(a, b)))
        })
        .collect()
}
