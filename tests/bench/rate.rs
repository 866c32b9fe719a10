//! The QP of resolved motion rate (28), (29) at a posture of the walk, and the cost of sealing a message.

use crate::robot::{Activity, Recording};
use controller::rate::{bias, resolve, resolve_bounded, resolve_by_interior_points};
use controller::support::{Chain, Joints, Task, TaskVector};
use divan::{Bencher, black_box};
use messages::wire::{Command, Sensors, Stamped};

/// The input of the QP.
fn asked() -> (Task, TaskVector, Joints) {
    let Recording { scene, states, .. } = Recording::of(Activity::Walking, &[]);
    let state = &states[states.len() / 4];
    let angles = Joints::from_iterator(state.x[state.x.len() - 8..].iter().copied());
    let task = Chain::new(&scene.bodies).expect("a biped").task(&angles);
    let bias = bias(task.swing_pitch);
    (task, TaskVector::from([0.2, 0.05, 0.0, 0.3, 0.0, 0.1, 0.0]), bias)
}

#[divan::bench(sample_count = 200, sample_size = 64)]
fn rate_qp_closed_form(bencher: Bencher) {
    let (task, xdot, bias) = asked();
    bencher.bench_local(|| resolve(black_box(&task.jacobian), &xdot, &bias).expect("bent knees"));
}

#[divan::bench(sample_count = 200, sample_size = 64)]
fn rate_qp_with_bounds(bencher: Bencher) {
    let (task, xdot, bias) = asked();
    let bound = Joints::repeat(0.9 * resolve(&task.jacobian, &xdot, &bias).expect("bent knees").amax());
    bencher.bench_local(|| resolve_bounded(black_box(&task.jacobian), &xdot, &bias, &-bound, &bound));
}

#[divan::bench(sample_count = 200, sample_size = 1)]
fn rate_qp_with_bounds_by_interior_points(bencher: Bencher) {
    let (task, xdot, bias) = asked();
    let bound = Joints::repeat(0.9 * resolve(&task.jacobian, &xdot, &bias).expect("bent knees").amax());
    bencher.bench_local(|| resolve_by_interior_points(black_box(&task.jacobian), &xdot, &bias, &-bound, &bound));
}

#[divan::bench(sample_count = 200, sample_size = 64)]
fn seal_and_check_sensors(bencher: Bencher) {
    let sensors = Sensors::default();
    bencher.bench_local(|| black_box(&sensors).sealed().is_sound());
}

#[divan::bench(sample_count = 200, sample_size = 64)]
fn seal_and_check_command(bencher: Bencher) {
    let command = Command::default();
    bencher.bench_local(|| black_box(&command).sealed().is_sound());
}
