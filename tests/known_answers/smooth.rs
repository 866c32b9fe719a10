//! The comparison scenes without a closed-form solution, a sliding and turning puck and a rolling ball, compared with an accurate integration of
//! their equations. They distinguish laws and methods, because the direction of slip and the contact point change continuously.

use crate::support::{G, assert_near, plant, pose, run, spin, totals};
use nalgebra::{Rotation2, Vector2};
use plant::Plant;

/// The paper's method.
const PAPER: &[&str] = &["plant.method=SemiImplicitEuler", "plant.dt=0.001", "rate=1000"];
/// The settings of the scene itself.
const OWN: &[&str] = &[];
/// Event detection.
const BEST: &[&str] = &["plant.method=EventDriven"];

/// The state after a time, by the classical Runge-Kutta method in 5000 steps.
fn integrated<const N: usize>(mut state: [f64; N], time: f64, rate: impl Fn([f64; N]) -> [f64; N]) -> [f64; N] {
    let h = time / 5000.0;
    let moved = |state: [f64; N], by: f64, rates: [f64; N]| std::array::from_fn(|i| state[i] + by * rates[i]);
    for _ in 0..5000 {
        let a = rate(state);
        let b = rate(moved(state, 0.5 * h, a));
        let c = rate(moved(state, 0.5 * h, b));
        let d = rate(moved(state, h, c));
        state = std::array::from_fn(|i| state[i] + h / 6.0 * (a[i] + 2.0 * b[i] + 2.0 * c[i] + d[i]));
    }
    state
}

/// Yaw, and angular velocity about the vertical.
fn turned(plant: &Plant) -> [f64; 2] {
    let ahead = pose(plant).links[plant.model().base_link].rotation.column(0).into_owned();
    [ahead.y.atan2(ahead.x), spin(plant).z]
}

/// Errors of yaw and angular velocity. Each of three legs carries m g/3, and its friction opposes its own velocity.
fn puck(settings: &[&str]) -> [f64; 2] {
    let legs = [0.0, 120.0, 240.0].map(|degrees: f64| Rotation2::new(degrees.to_radians()) * Vector2::new(0.1, 0.0));
    let [yaw, .., rate] = integrated([0.0, 2.0, 0.0, 1.0], 0.5, |[yaw, vx, vy, spin]| {
        let mut sum = [spin, 0.0, 0.0, 0.0];
        for arm in legs.map(|leg| Rotation2::new(yaw) * leg) {
            let friction = -0.2 * G / 3.0 * Vector2::new(vx - spin * arm.y, vy + spin * arm.x).normalize();
            let moment = arm.perp(&friction);
            sum = [spin, sum[1] + friction.x, sum[2] + friction.y, sum[3] + moment / 0.01];
        }
        sum
    });
    assert_near("ω", rate, 0.706_702_218, 1e-9);
    let mut plant = plant("turn", settings);
    run(&mut plant, 0.5);
    let found = turned(&plant);
    [found[0] / yaw - 1.0, found[1] / rate - 1.0]
}

#[test]
fn a_puck_slides_and_turns_like_three_coulomb_points() {
    for (settings, most) in [(PAPER, 1e-3), (OWN, 1e-10), (BEST, 1e-12)] {
        let errors = puck(settings);
        println!("{settings:?}: yaw, rate off by {errors:?}");
        assert!(errors.iter().all(|error| error.abs() < most), "{settings:?}: {errors:?}");
    }
}

/// The observed order of the error, from steps of h and h/2.
fn order(error: impl Fn(&[&str]) -> f64, method: &str, [coarse, fine]: [f64; 2]) -> f64 {
    let of = |dt: f64| {
        let settings = [format!("plant.method={method}"), format!("plant.dt={dt}"), format!("rate={}", 1.0 / dt)];
        error(&settings.iter().map(String::as_str).collect::<Vec<_>>()).abs()
    };
    let order = (of(coarse) / of(fine)).log2() / (coarse / fine).log2();
    println!("{method}: order {order}");
    order
}

/// Impulse-based methods enforce sticking at the end of a step, which costs one order. Acceleration-based ones do not.
#[test]
fn errors_decrease_with_the_order_of_each_method() {
    for (method, wanted, steps) in [
        ("SemiImplicitEuler", 1.0, [2e-3, 1e-3]),
        ("MidpointMoreau", 1.0, [2e-3, 1e-3]),
        ("Rk4Impact", 4.0, [0.05, 0.025]),
    ] {
        assert_near(method, order(|settings| puck(settings)[0], method, steps), wanted, 0.1 * wanted);
    }
    for (method, wanted, steps) in [
        ("SemiImplicitEuler", 1.0, [2e-4, 1e-4]),
        ("MidpointMoreau", 1.0, [2e-4, 1e-4]),
        ("ImplicitMidpoint", 1.0, [2e-4, 1e-4]), // its contact law holds for K at the middle of the step
        ("Rk4Impact", 4.0, [0.001, 0.0005]),
    ] {
        assert_near(method, order(ball, method, steps), wanted, 0.1 * wanted);
    }
}

/// `Aligned` has a corner of each contact's square cone along its own slip, so it converges with smaller steps. Facets that are fixed in the
/// world brake all three legs along the same facet while their slip directions differ by less than the facets do. Nothing then brakes the
/// rotation, at any step.
#[test]
fn a_sliding_puck_turns_freely_under_fixed_facets_but_not_under_a_diamond_along_the_slip() {
    let error = |law: &str, dt: &str| {
        let law = format!("plant.law={law}");
        puck(&[law.as_str(), "plant.method=MoreauJean", &format!("plant.dt={dt}")])[1]
    };
    for law in ["Facets(4)", "Facets(8)", "Facets(16)"] {
        for dt in ["0.005", "0.001"] {
            let error = error(law, dt);
            println!("{law}, {dt} s: {error}");
            assert_near(law, error, 1.0 / 0.706_702_218 - 1.0, 1e-8);
        }
    }
    for law in ["Cone", "Aligned"] {
        let [coarse, fine] = ["0.005", "0.001"].map(|dt| error(law, dt).abs());
        println!("{law}: {coarse:e}, {fine:e}");
        assert!(coarse < 1e-3 && fine < 0.25 * coarse, "{law}: {coarse:e}, {fine:e}");
    }
}

/// Error of the angle of the eccentric ball [rad]; φ' follows from ½ (k² + r² + d² - 2 r d cos φ) φ'² - g d (1 - cos φ).
fn ball(settings: &[&str]) -> f64 {
    let (radius, offset, gyration, start) = (0.1, 0.04, 0.002, -1.2);
    let [angle, rate] = integrated([start, 0.0], 1.75, |[angle, rate]| {
        let inertia = gyration + radius * radius + offset * offset - 2.0 * radius * offset * angle.cos();
        [rate, -offset * angle.sin() * (radius * rate * rate + G) / inertia]
    });
    assert!(rate < -9.4, "it passes its lowest place at full speed: {rate} rad/s");
    let mut plant = plant("ball", settings);
    run(&mut plant, 1.75);
    let axis = pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned();
    axis.x.atan2(axis.z) - angle
}

#[test]
fn an_eccentric_ball_rolls_to_and_fro_by_lagranges_equation() {
    for (settings, most) in [(PAPER, 0.05), (OWN, 2e-6), (BEST, 1e-11)] {
        let error = ball(settings);
        println!("{settings:?}: angle off by {error:e} rad");
        assert!(error.abs() < most, "{settings:?}: {error:e} rad");
    }
}

/// The centre of a rolling ball advances by the radius times the angle.
#[test]
fn a_rolling_ball_does_not_slip() {
    for (settings, most) in [(OWN, 1e-8), (BEST, 1e-11)] {
        let mut plant = plant("ball", settings);
        let middle = |plant: &Plant| plant.truth().base_position[0];
        let begun = middle(&plant);
        run(&mut plant, 1.75);
        let axis = pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned();
        let slipped = middle(&plant) - begun - 0.1 * (axis.x.atan2(axis.z) + 1.2);
        println!("{settings:?}: slipped by {slipped:e} m; {:e} m aside", totals(&plant).com.y);
        assert!(slipped.abs() < most && totals(&plant).com.y.abs() < 1e-12, "{settings:?}: {slipped:e} m");
    }
}
