//! Claims about the resolved motion rate (28)-(29).

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use controller::rate::{bias, resolve, resolve_bounded};
use controller::support::{Chain, Joints, TaskVector};
use messages::robot::table_1;

const SEED: u64 = 28;

/// Bent-kneed random postures, task rates and foot pitches.
fn cases(n: usize) -> impl Iterator<Item = (controller::support::Task, TaskVector)> {
    let chain = Chain::new(&table_1()).unwrap();
    let mut random = fastrand::Rng::with_seed(SEED);
    println!("seed {SEED}");
    let crouch = Joints::from([0.0, 0.5, -1.5, 1.0, -1.0, 1.5, -0.5, 0.0]);
    (0..n).map(move |_| {
        let s = crouch + Joints::from_fn(|_, _| 0.3 * (random.f64() - 0.5));
        (chain.task(&s), TaskVector::from_fn(|_, _| random.f64() - 0.5))
    })
}

#[test]
fn the_closed_form_meets_29_and_no_step_along_its_null_space_lowers_28() {
    for (task, xdot) in cases(1000) {
        let c_0 = bias(task.swing_pitch);
        let q = resolve(&task.jacobian, &xdot, &c_0).unwrap();
        assert!((task.jacobian * q - xdot).amax() < 1e-11);
        let s = Joints::from([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
        let cost = |q: Joints| 0.5 * q.dot(&q) + 50.0 * s.dot(&q).powi(2) - c_0.dot(&q); // (28)
        // The null space of J: what is left of any vector after its projection on the rows.
        let any = Joints::from_fn(|i, _| (i as f64 + 1.0).sin());
        let rows = task.jacobian;
        let lambda = (rows * rows.transpose()).cholesky().unwrap().solve(&(rows * any));
        let null = (any - rows.transpose() * lambda).normalize();
        for t in [-1e-3, 1e-3] {
            assert!(cost(q + t * null) > cost(q));
        }
    }
}

#[test]
fn with_bounds_that_do_not_bind_the_interior_point_agrees_with_the_closed_form_to_1e_8() {
    let wide = Joints::repeat(1e3);
    let mut worst: f64 = 0.0;
    for (task, xdot) in cases(200) {
        let c_0 = bias(task.swing_pitch);
        let free = resolve(&task.jacobian, &xdot, &c_0).unwrap();
        let bounded = resolve_bounded(&task.jacobian, &xdot, &c_0, &-wide, &wide).unwrap();
        worst = worst.max((free - bounded).amax());
    }
    println!("largest difference {worst:.1e} rad/s");
    assert!(worst < 1e-8);
}

#[test]
fn a_bound_that_binds_is_kept_and_the_task_still_met() {
    let mut bound_cases = 0;
    for (task, xdot) in cases(200) {
        let c_0 = bias(task.swing_pitch);
        let free = resolve(&task.jacobian, &xdot, &c_0).unwrap();
        let limit = Joints::repeat(0.98 * free.amax());
        if let Some(q) = resolve_bounded(&task.jacobian, &xdot, &c_0, &-limit, &limit) {
            bound_cases += 1;
            assert!(q.amax() <= limit[0] + 1e-8);
            assert!((task.jacobian * q - xdot).amax() < 1e-8);
        }
    }
    assert!(bound_cases > 50, "only {bound_cases} feasible");
}

#[test]
fn a_straight_leg_is_reported_not_resolved() {
    let chain = Chain::new(&table_1()).unwrap();
    let task = chain.task(&Joints::zeros());
    assert!(resolve(&task.jacobian, &TaskVector::repeat(0.1), &Joints::zeros()).is_none());
}
