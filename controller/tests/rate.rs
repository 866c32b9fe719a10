//! Claims about the resolved motion rate (28)-(29).

#![allow(clippy::unwrap_used, reason = "a test fails by panicking")]

use biped_controller::rate::{bias, resolve, resolve_bounded, resolve_by_interior_points};
use biped_controller::support::{Chain, Joints, TaskVector};
use messages::robot::table_1;

const SEED: u64 = 28;

/// Random postures with bent knees, and random task rates.
fn cases(n: usize) -> impl Iterator<Item = (biped_controller::support::Task, TaskVector)> {
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
fn the_closed_form_satisfies_29_and_minimises_28_along_the_null_space() {
    for (task, xdot) in cases(1000) {
        let c_0 = bias(task.swing_pitch);
        let q = resolve(&task.jacobian, &xdot, &c_0).unwrap();
        assert!((task.jacobian * q - xdot).amax() < 1e-11);
        let s = Joints::from([0.0, 1.0, 1.0, 1.0, 1.0, 1.0, 1.0, 0.0]);
        let cost = |q: Joints| 0.5 * q.dot(&q) + 50.0 * s.dot(&q).powi(2) - c_0.dot(&q); // (28)
        // Null space of J: an arbitrary vector minus its projection on the rows.
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
fn with_inactive_bounds_the_interior_point_method_agrees_with_the_closed_form_to_1e_8() {
    let wide = Joints::repeat(1e3);
    let mut worst: f64 = 0.0;
    for (task, xdot) in cases(200) {
        let c_0 = bias(task.swing_pitch);
        let free = resolve(&task.jacobian, &xdot, &c_0).unwrap();
        let bounded = resolve_by_interior_points(&task.jacobian, &xdot, &c_0, &-wide, &wide).unwrap();
        worst = worst.max((free - bounded).amax());
    }
    println!("largest difference {worst:.1e} rad/s");
    assert!(worst < 1e-8);
}

/// Random bounds, from wide ones to infeasible ones.
#[test]
fn bounded_rates_agree_with_an_interior_point_method() {
    let mut random = fastrand::Rng::with_seed(SEED);
    let mut symmetric = |size: f64| size * (2.0 * random.f64() - 1.0);
    let (mut bound, mut refused, mut given_up) = (0, 0, 0);
    for (task, xdot) in cases(2000) {
        let (rows, c_0) = (&task.jacobian, bias(symmetric(0.1)));
        let free = resolve(rows, &xdot, &c_0).unwrap();
        let size = free.amax() * (1.0 + symmetric(0.4));
        let [lower, upper] = [-size, size].map(|edge| Joints::from_fn(|_, _| symmetric(0.1) + edge));
        let ours = resolve_bounded(rows, &xdot, &c_0, &lower, &upper);
        let theirs = resolve_by_interior_points(rows, &xdot, &c_0, &lower, &upper);
        if let Some(ours) = ours {
            assert!((rows * ours - xdot).amax() < 1e-12 * size.max(1.0), "(29)");
            assert!(ours.iter().zip(&lower).all(|(rate, low)| rate >= low), "{ours} below {lower}");
            assert!(ours.iter().zip(&upper).all(|(rate, high)| rate <= high), "{ours} above {upper}");
        }
        match (ours, theirs) {
            (Some(ours), Some(theirs)) => {
                bound += usize::from((ours - free).amax() > 1e-6);
                let difference = (ours - theirs).amax() / size;
                assert!(difference < 1e-8, "{difference:e}: {ours} beside {theirs}");
            }
            (None, None) => refused += 1,
            // Ours keeps the bounds and satisfies (29), as checked above. The interior-point method gives up where the feasible set is small.
            (Some(_), None) => given_up += 1,
            // The interior-point method accepts rates that are infeasible within its tolerance.
            (None, Some(_)) => {
                let slack = Joints::repeat(1e-6 * size);
                assert!(resolve_bounded(rows, &xdot, &c_0, &(lower - slack), &(upper + slack)).is_some());
            }
        }
    }
    println!("{bound} of 2000 at a bound, {refused} without any solution, {given_up} that interior points give up");
    assert!(bound > 100 && refused > 100 && given_up < 10, "{bound}, {refused}, {given_up}");
}

#[test]
fn an_active_bound_is_kept_and_the_task_is_still_satisfied() {
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
fn a_straight_leg_is_reported_as_singular() {
    let chain = Chain::new(&table_1()).unwrap();
    let task = chain.task(&Joints::zeros());
    assert!(resolve(&task.jacobian, &TaskVector::repeat(0.1), &Joints::zeros()).is_none());
}
