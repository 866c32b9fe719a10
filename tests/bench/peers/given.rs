//! The common inputs of all engines: states of the robot, and quadratic programs.

use crate::robot::{Activity, Recording};
use controller::rate::{bias, resolve, resolve_bounded};
use controller::support::{Chain, Joints, TaskVector};
use messages::wire::{JOINTS, Truth};
use nalgebra::{Quaternion, UnitQuaternion, Vector3};
use plant::contact::{Memory, Problem, Solver};
use serde_json::{Value, json};
use std::fmt::Write;

/// Number of programs in a family.
const PROGRAMS: usize = 50;

/// Joints from hip to foot, left leg first, all about positive axes, as `biped8.xml` has them.
fn in_their_order(ours: &[f64; JOINTS]) -> [f64; JOINTS] {
    std::array::from_fn(|k| if k < 4 { -ours[3 - k] } else { ours[k] })
}

/// A header for each situation: name, count, gravity, friction, drive inertia, stiffness and damping of joints; then
/// position, quaternion, velocity in W, angular velocity in the body frame, angles, rates and torques, a line for each state.
pub fn states(recordings: &[(Activity, Recording)]) -> String {
    let mut text = String::new();
    for (activity, recording) in recordings {
        let Recording { scene, window, torques, truths, .. } = recording;
        let joint = scene.bodies.iter().find_map(|body| body.joint.as_ref()).expect("joints");
        let plant = &scene.plant;
        let numbers = [plant.gravity, plant.friction, plant.drive_inertia, joint.stiffness, joint.damping];
        let numbers = numbers.map(|number| number.to_string()).join(" ");
        let _ = writeln!(text, "{} {} {numbers}", name(*activity), truths.len());
        for (truth, torques) in truths.iter().zip(&torques[window.start..]) {
            let Truth { base_position, base_orientation: [w, x, y, z], base_velocity, base_spin, .. } = *truth;
            let turn = UnitQuaternion::from_quaternion(Quaternion::new(w, x, y, z));
            let spin: [f64; 3] = turn.inverse_transform_vector(&Vector3::from(base_spin)).into();
            let joints = [&truth.angle, &truth.rate, &torques.torque].map(in_their_order);
            let base = [&base_position[..], &[w, x, y, z], &base_velocity, &spin].concat();
            let numbers: Vec<_> = base.iter().chain(joints.as_flattened()).map(f64::to_string).collect();
            let _ = writeln!(text, "{}", numbers.join(" "));
        }
    }
    text
}

/// The name of a situation in files and tables.
pub fn name(activity: Activity) -> String {
    format!("{activity:?}").to_lowercase()
}

/// Programs by family: minimise x·h x/2 + c·x with low <= rows x <= high. With the solution of this simulator.
pub fn programs(recordings: &[(Activity, Recording)]) -> String {
    let mut families = serde_json::Map::new();
    for (activity, recording) in recordings.iter().filter(|(activity, _)| *activity != Activity::Flying) {
        families.insert(name(*activity), contacts(recording).map(energy).collect());
    }
    families.insert("rate".into(), rates(&recordings[2].1).map(rate).collect());
    Value::Object(families).to_string()
}

/// A selection of the problems.
pub fn contacts(recording: &Recording) -> impl Iterator<Item = &Problem> {
    recording.problems.iter().step_by((recording.problems.len() / PROGRAMS).max(1)).take(PROGRAMS)
}

/// The energy minimum (14) with |f_1| + |f_2| <= μ f_N, v_N relative to the allowed approach velocity: `EnergyQpGap`. If A is
/// singular, the impulses are not unique, but the velocities are.
fn energy(problem: &Problem) -> Value {
    let m = problem.rows();
    let (mut c, mut rows) = (problem.drift.clone(), vec![]);
    for i in 0..problem.contacts {
        c[3 * i] += problem.approach[i];
        for [a, b] in [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]] {
            let mut row = vec![0.0; m];
            row[3 * i..3 * i + 3].copy_from_slice(&[-problem.friction[i], a, b]);
            rows.push(row);
        }
    }
    let mut solver = Solver::default();
    solver.solve(problem, messages::scene::Law::EnergyQpGap, &mut Memory::default());
    let h: Vec<_> = problem.delassus.chunks(m).collect();
    let (low, high) = (vec![Value::Null; rows.len()], vec![0.0; rows.len()]);
    json!({ "h": h, "c": c, "rows": rows, "low": low, "high": high, "ours": solver.impulse, "unique": false })
}

/// (28), (29) at a posture: task, bias, bound on every rate.
pub struct Rate {
    pub task: controller::support::Task,
    pub xdot: TaskVector,
    pub bias: Joints,
    pub bound: Joints,
}

/// At postures of the walk, for random task rates. Every bound is chosen so that one joint reaches it.
pub fn rates(recording: &Recording) -> impl Iterator<Item = Rate> {
    let chain = Chain::new(&recording.scene.bodies).expect("a biped");
    let mut random = fastrand::Rng::with_seed(28);
    recording.truths.iter().step_by(recording.truths.len() / PROGRAMS).filter_map(move |truth| {
        let task = chain.task(&Joints::from(truth.angle));
        let (xdot, bias) = (TaskVector::from_fn(|_, _| random.f64() - 0.5), bias(task.swing_pitch));
        let bound = Joints::repeat(0.98 * resolve(&task.jacobian, &xdot, &bias)?.amax());
        resolve_bounded(&task.jacobian, &xdot, &bias, &-bound, &bound)?;
        Some(Rate { task, xdot, bias, bound })
    })
}

fn rate(Rate { task, xdot, bias, bound }: Rate) -> Value {
    let ours = resolve_bounded(&task.jacobian, &xdot, &bias, &-bound, &bound).expect("it was solved before");
    let s = |k: usize| if k.is_multiple_of(JOINTS - 1) { 0.0 } else { 1.0 };
    let unit = |i: usize, k: usize| if i == k { 1.0 } else { 0.0 };
    let square = |of: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..JOINTS).map(|i| (0..JOINTS).map(|k| of(i, k)).collect()).collect()
    };
    let task_rows = task.jacobian.row_iter().map(|row| row.iter().copied().collect::<Vec<_>>());
    let rows: Vec<_> = task_rows.chain(square(&unit)).collect();
    let low: Vec<_> = xdot.iter().copied().chain(bound.iter().map(|bound| -bound)).collect();
    let high: Vec<_> = xdot.iter().chain(bound.iter()).copied().collect();
    json!({
        "h": square(&|i, k| unit(i, k) + 100.0 * s(i) * s(k)),
        "c": bias.iter().map(|c| -c).collect::<Vec<_>>(),
        "rows": rows, "low": low, "high": high, "ours": ours.as_slice(), "unique": true,
    })
}
