//! Passive walkers in the general simulator: scenes 7, 8 and 9. Feet are contact points, the contact law computes the impact of a step, and limit cycle
//! and multipliers are those of the return map from just after one step to just after the next.

use crate::steps::{extrapolated, limit_cycle, walk_on};
use crate::support::{advance, assert_near, pose, scene};
use messages::scene::Scene;
use nalgebra::{Complex, DVector};
use plant::Plant;
use plant::state::State;
use std::f64::consts::PI;

/// A scene with a method, and with one step of the given size in each control period.
fn by(name: &str, method: &str, h: f64) -> Scene {
    let settings = [
        format!("plant.method={method}"),
        format!("plant.dt={h}"),
        format!("rate={}", 1.0 / h),
        "plant.tolerance_step=1e-12".into(),
    ];
    scene(name, &settings.each_ref().map(String::as_str))
}

/// Return map of a two-legged walker. The coordinates just after a step are the angle of the stance leg and the rates of both legs, measured forward
/// from the normal of the ground. The angle of the other leg is opposite.
fn legs(scene: &Scene, at: &DVector<f64>) -> (DVector<f64>, f64) {
    let (angle, rate, other) = (at[0], at[1], at[2]);
    let mut scene = scene.clone();
    let (sin, cos) = angle.sin_cos();
    scene.initial.position = [sin, 0.0, cos];
    scene.initial.orientation_deg = [0.0, angle.to_degrees(), 0.0];
    scene.initial.velocity = [rate * cos, 0.0, -rate * sin];
    scene.initial.angular_velocity = [0.0, rate, 0.0];
    scene.initial.joints = vec![-2.0 * angle];
    scene.initial.joint_rates = vec![other - rate];
    let mut plant = Plant::new(&scene).expect("a walker");
    let step = walk_on(&mut plant, 0, scene.plant.dt);
    assert_eq!(step.foot, 1);
    // the left leg is the base
    let (x, v) = (&step.state.x, &step.state.xdot);
    (DVector::from_vec(vec![x[2] + x[3], v[2] + v[3], v[2]]), step.time)
}

/// Return map of a rimless wheel that stands on two spokes and rotates about the front one.
fn wheel(scene: &Scene, at: &DVector<f64>) -> (DVector<f64>, f64) {
    let mut scene = scene.clone();
    let (sin, cos) = (PI / 8.0).sin_cos();
    scene.initial.position = [0.0, 0.0, cos];
    scene.initial.velocity = [at[0] * cos, 0.0, at[0] * sin];
    scene.initial.angular_velocity = [0.0, at[0], 0.0];
    let mut plant = Plant::new(&scene).expect("a wheel");
    let front = {
        let (pose, corners) = (pose(&plant), &plant.model().contact_points);
        (0..8).find(|&i| pose.lowest(&corners[i]).x > 0.1 && pose.lowest(&corners[i]).z < -0.9).expect("a front spoke")
    };
    let step = walk_on(&mut plant, front, scene.plant.dt);
    (DVector::from_vec(vec![step.state.xdot[2]]), step.time)
}

/// The limit cycle of a rimless wheel with squared radius of gyration `gyration` and spokes of 1 m on a slope of 0.08 rad, in closed form.
fn wheel_by_hand(gyration: f64) -> [f64; 3] {
    let half = PI / 8.0;
    let ratio = (gyration + (2.0 * half).cos()) / (1.0 + gyration);
    let before = (4.0 * 9.81 / (1.0 + gyration) * half.sin() * 0.08_f64.sin() / (1.0 - ratio * ratio)).sqrt();
    [ratio * before, before, ratio * ratio]
}

#[test]
fn a_rimless_wheel_has_the_limit_cycle_of_its_closed_form() {
    let scene = by("rimless-wheel", "EventDriven", 5e-3);
    let [after, before, multiplier] = wheel_by_hand(0.0);
    assert_near("w after", after, 1.095_462_839_648, 1e-12);
    assert_near("w before", before, 1.549_218_404_905, 1e-12);
    let cycle = |gyration: f64| {
        let mut scene = scene.clone();
        scene.bodies[0].inertia = Some([gyration; 3]);
        let (at, multipliers, period) = limit_cycle(&|at| wheel(&scene, at), DVector::from_vec(vec![1.1]));
        let [exact, _, exact_multiplier] = wheel_by_hand(gyration);
        println!(
            "gyration {gyration}: w {:e} off, multiplier {:e} off",
            at[0] - exact,
            multipliers[0].re - exact_multiplier
        );
        assert_near("w after", at[0], exact, 1e-9);
        assert_near("multiplier", multipliers[0].re, exact_multiplier, 1e-4);
        [at[0], multipliers[0].re, period]
    };
    let (one, two) = (cycle(1e-5), cycle(2e-5));
    let limit = [0, 1, 2].map(|k| 2.0 * one[k] - two[k]);
    println!("as the wheel's own inertia vanishes: {limit:?}");
    assert_near("w after", limit[0], after, 1e-9);
    assert_near("multiplier", limit[1], multiplier, 1e-4);
    // the lift-off of the rear spoke is known to 1e-9 m
    assert_near("period", limit[2], 1.034_549_811_423, 4e-9);
    assert_near("speed", 2.0 * (PI / 8.0).sin() / limit[2], 0.739_806_683, 4e-9);
}

#[test]
fn the_compass_gait_has_its_known_limit_cycle() {
    let scene = by("compass-gait", "EventDriven", 5e-3);
    let slope = 0.0525;
    let guess = DVector::from_vec(vec![-0.27, 1.09, 0.37]);
    let (at, multipliers, period) = limit_cycle(&|at| legs(&scene, at), guess);
    println!("{at} {multipliers:?} {period}");
    // the literature measures angles from the vertical
    assert_near("standing leg", at[0] + slope, -0.218_774_617_980, 1e-6);
    assert_near("swinging leg", -at[0] + slope, 0.323_774_617_980, 1e-6);
    assert_near("its rate", at[1], 1.092_866_810_580, 1e-6);
    assert_near("the other's", at[2], 0.376_134_593_531, 1e-6);
    assert_near("period", period, 0.734_460_621_337, 1e-6);
    let exact = [Complex::new(-0.202_216_100_1, 0.543_414_971_4), Complex::new(-0.202_216_100_1, -0.543_414_971_4)];
    for (multiplier, exact) in multipliers.iter().zip([exact[0], exact[1], Complex::new(0.131_386_707_2, 0.0)]) {
        assert_near("multiplier", (multiplier - exact).norm(), 0.0, 1e-4);
    }
}

/// Twenty more steps, on tiles with the length of a step.
#[test]
fn the_compass_gait_keeps_walking() {
    let mut scene = scene("compass-gait", &[]);
    (scene.plant.dt, scene.rate) = (0.734_460_621_337 / 700.0, 700.0 / 0.734_460_621_337);
    let mut plant = Plant::new(&scene).expect("a walker");
    let start = plant.state().x[0];
    for _ in 0..20 * 700 {
        advance(&mut plant);
    }
    let way = plant.state().x[0] - start;
    println!("{way} m in 20 steps");
    assert_near("way", way, 20.0 * 2.0 * 0.271_274_617_980_f64.sin(), 1e-6);
}

/// Sets the mass of each foot to `foot`, with a hip of 1 kg.
fn with_feet(scene: &Scene, foot: f64) -> Scene {
    let mut scene = scene.clone();
    let [left, right] = &mut scene.bodies[..] else { unreachable!("two legs") };
    left.mass = 1.0 + foot;
    left.com = [0.0, 0.0, -foot / (1.0 + foot)];
    left.inertia = Some([foot / (1.0 + foot), foot / (1.0 + foot), 1e-9]);
    right.mass = foot;
    right.inertia = Some([1e-9 * foot; 3]);
    scene
}

/// The limit of massless feet, extrapolated from three small masses.
#[test]
fn the_simplest_walker_has_its_known_limit_cycle() {
    let scene = by("simplest-walker", "EventDriven", 2e-2);
    let cycle = |foot: f64| {
        let scene = with_feet(&scene, foot);
        let guess = DVector::from_vec(vec![-0.2003, 0.19983, 0.184]);
        let (at, multipliers, period) = limit_cycle(&|at| legs(&scene, at), guess);
        println!("feet of {foot}: {:.9} {:.9} {:?} {period:.9}", at[0], at[1], multipliers);
        [at[0], at[1], at[2], period, multipliers[0].re, multipliers[0].im, multipliers[2].re]
    };
    // Neville's scheme at zero
    let masses = [2e-4, 1e-4, 5e-5];
    let mut rows = masses.map(cycle);
    for order in 1..masses.len() {
        for k in (order..masses.len()).rev() {
            let (near, far) = (masses[k], masses[k - order]);
            rows[k] = std::array::from_fn(|i| (far * rows[k][i] - near * rows[k - 1][i]) / (far - near));
        }
    }
    let limit = rows[masses.len() - 1];
    println!("without: {limit:?}");
    let (angle, rate) = (0.200_310_900_544_f64, -0.199_832_473_005);
    assert_near("angle", -limit[0], angle, 1e-6);
    assert_near("rate", -limit[1], rate, 1e-6);
    assert_near("the other's", -limit[2], rate * (2.0 * angle).cos(), 1e-6);
    assert_near("period", limit[3], 3.882_463_752_852, 1e-5);
    assert_near("multiplier", limit[4], -0.190_099_841_066, 1e-4);
    assert_near("multiplier", limit[5], 0.557_598_776_682, 1e-4);
    assert_near("third multiplier", limit[6], 0.0, 1e-4);
}

/// State of a walk from the limit cycle when the next stance leg is upright: time, angle between the legs, and both rates. That is late enough after
/// the impact for its irregularity within a step to decay.
fn upright(method: &str, h: f64) -> DVector<f64> {
    let mut plant = Plant::new(&by("compass-gait", method, h)).expect("a walker");
    let angle = |state: &State| state.x[2] + state.x[3];
    let mut before = plant.state().clone();
    for steps in 0.. {
        assert!(f64::from(steps) * h < 2.0, "it does not walk");
        advance(&mut plant);
        let now = plant.state().clone();
        // the right leg swings first and is upright twice: as it swings past the left one, and as the stance leg
        if f64::from(steps) * h > 0.9 && angle(&before) < 0.0 && angle(&now) >= 0.0 {
            let pair = [before, now];
            let (mut low, mut high) = (0.0, h);
            for _ in 0..60 {
                let middle = 0.5 * (low + high);
                if angle(&extrapolated(&pair, middle, h)) < 0.0 { low = middle } else { high = middle }
            }
            let state = extrapolated(&pair, high, h);
            return DVector::from_vec(vec![f64::from(steps) * h + high, state.x[2], state.xdot[2], state.xdot[3]]);
        }
        before = now;
    }
    unreachable!()
}

/// Order of the error, and the error at 1 ms. The order is the slope of a fit over many step sizes, because single errors depend on the phase of the
/// impact within a step.
fn order(method: &str, exact: &DVector<f64>) -> (f64, f64) {
    let steps = (0..24).map(|k| 4e-3 * 0.92_f64.powi(k));
    let points: Vec<_> = steps.map(|h| (h.ln(), (upright(method, h) - exact).norm().ln())).collect();
    let mean = |of: &dyn Fn(&(f64, f64)) -> f64| points.iter().map(of).sum::<f64>() / points.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let slope = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x) * (p.0 - x));
    (slope, (y + slope * (1e-3_f64.ln() - x)).exp())
}

/// With impulses at the end of a step, every method has first order while a leg pivots. With forces in every stage, it keeps its order.
#[test]
fn the_compass_gait_converges_with_the_order_of_the_method() {
    let expected =
        [("SemiImplicitEuler", 0.8), ("MoreauJean", 0.8), ("MidpointMoreau", 0.8), ("Rk4", 0.8), ("Rk4Impact", 1.8)];
    let exact = upright("EventDriven", 1e-3);
    for (method, least) in expected {
        let (slope, error) = order(method, &exact);
        println!("{method:<18} order {slope:.2}, error at 1 ms {error:.1e}");
        assert!(slope > least, "{method}: order {slope}");
    }
}
