//! This simulator, timed like `mujoco.c`: each stage by many calls at each state, a step once from each state.

use super::{Times, given, median};
use crate::robot::{Activity, Recording, Replay};
use controller::rate::resolve_bounded;
use messages::scene::Law;
use plant::composite::Composite;
use plant::contact::{Memory, Problem, Solver};
use plant::delassus::{ContactMap, Free};
use plant::detect::touching;
use plant::factor::{Factor, PathMatrix};
use plant::ground::GroundHeights;
use plant::kinematics::{self, Pose};
use plant::model::Model;
use std::hint::black_box;
use std::time::Instant;

/// Number of calls of a stage at each state.
const REPEATS: u32 = 16;

/// Adds the times of a round.
pub fn measure(recordings: &[(Activity, Recording)], times: &mut Times) {
    let mut add = |situation: &str, stage: &str, ns: f64| {
        times.entry((situation.into(), stage.into())).or_default().push(ns);
    };
    for (activity, recording) in recordings {
        let name = given::name(*activity);
        add(&name, "step", step(*activity, &["plant.method=SemiImplicitEuler".into()]));
        add(&name, "step of second order", step(*activity, &["plant.method=MidpointContact".into()]));
        for (stage, ns) in stages(recording) {
            add(&name, stage, ns);
        }
        let contacts: Vec<_> = recording.problems.iter().map(|problem| problem.contacts as f64).collect();
        if !contacts.is_empty() {
            add(&name, "contacts", median(&contacts));
            add(&name, "Coulomb's law, warm", contact(recording.problems.iter(), Law::DEFAULT, true));
            add(&name, "Coulomb's law, cold", contact(given::contacts(recording), Law::DEFAULT, false));
            add(&name, "convex law, cold", contact(given::contacts(recording), Law::EnergyQpGap, false));
        }
    }
    let rates: Vec<_> = given::rates(&recordings[2].1).collect();
    let solve = |rate: &given::Rate| {
        let given::Rate { task, xdot, bias, bound } = rate;
        time(REPEATS, || {
            black_box(resolve_bounded(&task.jacobian, xdot, bias, &-bound, bound));
        })
    };
    add("rate", "rate QP within bounds", median(&rates.iter().map(solve).collect::<Vec<_>>()));
}

/// Mean time of a call in a sequence of several [ns].
fn time(calls: u32, mut call: impl FnMut()) -> f64 {
    let begun = Instant::now();
    (0..calls).for_each(|_| call());
    let all = begun.elapsed();
    let read = Instant::now();
    (all.as_secs_f64() - read.elapsed().as_secs_f64()).max(0.0) * 1e9 / f64::from(calls)
}

fn step(activity: Activity, settings: &[String]) -> f64 {
    let recording = Recording::of(activity, settings);
    let count = 3 * recording.window.len();
    let mut replay = Replay::of(recording);
    let step = |_| {
        let torques = replay.torques();
        time(1, || replay.advance(&torques))
    };
    median(&(0..count).map(step).collect::<Vec<_>>())
}

/// Times of the stages without a contact law: medians over the states.
fn stages(recording: &Recording) -> Vec<(&'static str, f64)> {
    let Recording { scene, states, .. } = recording;
    let model = Model::new(scene).expect("a good scene");
    let (mut composite, mut pose, mut factor) = (Composite::new(&model), Pose::new(&model), Factor::new(&model));
    let (mut h, mut b) = (PathMatrix::new(&model), vec![0.0; model.dofs()]);
    let (mut map, mut touches) = (ContactMap::new(&model), vec![]);
    let ground = GroundHeights::plane(&model);
    let mut lists: [Vec<f64>; 6] = Default::default();
    for state in states {
        let xdot = &state.xdot;
        lists[0].push(time(REPEATS, || kinematics::pose(&model, black_box(state), &mut pose)));
        lists[1].push(time(REPEATS, || composite.inertia(&model, black_box(&pose), &mut h)));
        lists[2].push(time(REPEATS, || composite.bias(&model, black_box(&pose), xdot, &mut b)));
        lists[3].push(time(REPEATS, || factor.factorize(&model, black_box(&h)).expect("positive definite")));
        lists[4].push(time(REPEATS, || {
            touching(&model, &ground, black_box(&pose), Law::Cone, 1e-3, xdot, &mut touches);
            let free = Free { pose: &pose, factor: &factor, rate: xdot };
            map.drift(&model, &free, &touches, Law::Cone, |_, drift| drift);
            map.assemble(&model, &free, &touches);
        }));
        lists[5].push(time(REPEATS, || {
            kinematics::pose(&model, black_box(state), &mut pose);
            composite.inertia(&model, &pose, &mut h);
            composite.bias(&model, &pose, xdot, &mut b);
            factor.factorize(&model, &h).expect("positive definite");
            factor.solve(&model, &mut b);
        }));
    }
    let names = ["kinematics", "inertia", "bias", "factor", "constraint", "dynamics"];
    names.into_iter().zip(lists.iter().map(|list| median(list))).collect()
}

/// Time of a contact law: median over consecutive problems.
fn contact<'a>(problems: impl Iterator<Item = &'a Problem>, law: Law, warm: bool) -> f64 {
    let (mut solver, mut memory) = (Solver::default(), Memory::default());
    let mut solve = |problem: &Problem| {
        time(1, || {
            if !warm {
                memory = Memory::default();
            }
            black_box(solver.solve(problem, law, &mut memory));
        })
    };
    median(&problems.map(&mut solve).collect::<Vec<_>>())
}
