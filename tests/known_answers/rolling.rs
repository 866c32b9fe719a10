//! Rolling balls: the contact point moves along the body.

use crate::support::{G, assert_near, clearance, plant, run, scene, spin, step, totals};
use plant::Plant;

/// Friction accelerates the rotation of the ball while m (v + 2/5 r w) stays constant. From the time 2 v/(7 μ g) on, the ball rolls at 5/7 v.
#[test]
fn a_sliding_ball_ends_rolling_at_five_sevenths_of_its_speed() {
    let (mu, t) = (0.3, 2.0 / (7.0 * 0.3 * G));
    assert_near("t*", t, 0.097_082_7, 1e-7);
    let mut plant = plant("roll", &[]);
    run(&mut plant, 0.05);
    assert_near("v while it slides", totals(&plant).com_velocity.x, 1.0 - mu * G * 0.05, 1e-12);
    run(&mut plant, 0.098);
    for _ in 0..400 {
        let v = totals(&plant).com_velocity;
        assert_near("v", v.x, 5.0 / 7.0, 1e-12);
        assert_near("sideways", v.y, 0.0, 1e-15);
        assert_near("r w", 0.1 * spin(&plant).y, 5.0 / 7.0, 1e-12);
        assert_near("gap", clearance(&plant), 0.0, 1e-12);
        step(&mut plant);
    }
}

/// A ball dropped from h bounces for sqrt(2 h/g) (1 + e)/(1 - e), and then rests.
#[test]
fn a_bouncing_ball_comes_to_rest_at_the_end_of_infinitely_many_bounces() {
    let exact = (2.0 / G).sqrt() * 3.0;
    assert_near("time of rest", exact, 1.354_570_923, 1e-9);
    for dt in [1e-3, 1e-4] {
        let mut plant = plant("zeno", &[&format!("plant.dt={dt}")]);
        let (mut top, mut last) = (0.0_f64, 0.0);
        while plant.time_ns() < 2_000_000_000 {
            step(&mut plant);
            let (t, height) = (plant.time_ns() as f64 * 1e-9, clearance(&plant));
            if t > 0.46 {
                top = top.max(height);
            }
            if height > G * dt * dt {
                last = t;
            }
        }
        println!("dt {dt}: last off the ground at {last} s, {:e} s off; first rebound to {top} m", last - exact);
        assert_near("height of the first rebound", top, 0.25, 5.0 * dt);
        assert_near("time of rest", last, exact, 40.0 * dt);
        assert_near("energy left", totals(&plant).kinetic, 0.0, 1e-12);
    }
}

/// With event detection the time is exact, although there are infinitely many impacts: where they accumulate, one impulse replaces them.
#[test]
fn event_detection_finds_the_time_when_a_bouncing_ball_comes_to_rest() {
    let exact = (2.0 / G).sqrt() * 3.0;
    for method in ["Rk4Impact", "EventDriven"] {
        let mut plant = plant("zeno", &[&format!("plant.method={method}")]);
        run(&mut plant, 0.6);
        let v = totals(&plant).com_velocity.z;
        // the first rebound has half the impact speed
        let [impact, speed] = [(2.0 / G).sqrt(), 0.5 * (2.0 * G).sqrt()];
        assert_near("velocity on the first rebound", v, speed - G * (0.6 - impact), 1e-11);
        run(&mut plant, exact - 2e-3);
        assert!(totals(&plant).kinetic > 0.0);
        run(&mut plant, exact + 1e-3);
        let rest = totals(&plant).kinetic;
        println!("{method}: energy {rest:e} J, gap {:e} m after the last bounce", clearance(&plant));
        assert_near("energy left", rest, 0.0, 1e-12);
        assert_near("gap", clearance(&plant), 0.0, 1e-8);
    }
}

/// The start of rolling is detected at its exact time, which lies within a step.
#[test]
fn event_detection_finds_the_time_when_a_ball_starts_rolling() {
    for method in ["Rk4Impact", "EventDriven"] {
        for (part, rolls) in [(1.0 - 1e-9, false), (1.0 + 1e-9, true)] {
            let start = 2.0 / (7.0 * 0.3 * G);
            let mut scene = scene("roll", &[&format!("plant.method={method}")]);
            scene.plant.dt = start * part / 50.5;
            let mut plant = Plant::new(&scene).expect("a ball");
            for _ in 0..50 {
                step(&mut plant);
            }
            assert_near("v", totals(&plant).com_velocity.x, 1.0 - 0.3 * G * scene.plant.dt * 50.0, 1e-12);
            scene.plant.dt = start * part / 50.0;
            let mut plant = Plant::new(&scene).expect("a ball");
            for _ in 0..50 {
                step(&mut plant);
            }
            let slip = totals(&plant).com_velocity.x - 0.1 * spin(&plant).y;
            assert_eq!(slip < 0.5e-9, rolls, "{method}: slip {slip:e}");
            assert_near("v", totals(&plant).com_velocity.x, 5.0 / 7.0, 1e-8);
        }
    }
}

/// A ball with enough back spin returns: its final velocity is 5/7 v - 2/7 r w.
#[test]
fn a_ball_with_back_spin_returns() {
    let mut plant = plant("roll", &["initial.angular_velocity=[0.0, -50.0, 0.0]", "duration=1.0"]);
    run(&mut plant, 1.0);
    assert_near("v", totals(&plant).com_velocity.x, (5.0 - 2.0 * 5.0) / 7.0, 1e-11);
}

/// A ball with an eccentric centre of mass rolls without slip. Its energy is constant up to the order of the step.
#[test]
fn an_eccentric_ball_rocks_about_its_lowest_position_without_gaining_energy() {
    let settings = ["bodies.ball.com=[0.03, 0.0, 0.0]", "initial.velocity=[0.0, 0.0, 0.0]", "plant.friction=1.0"];
    let energy = |dt: &str| {
        let mut plant = plant("roll", &[&settings[..], &[dt]].concat());
        let start = totals(&plant);
        let mut drift: f64 = 0.0;
        for _ in 0..(0.5 / dt[9..].parse::<f64>().expect("a number")) as usize {
            step(&mut plant);
            let now = totals(&plant);
            drift = drift.max((now.kinetic + now.potential - start.kinetic - start.potential).abs());
            assert!(clearance(&plant).abs() < 1e-4);
        }
        drift
    };
    let (coarse, fine) = (energy("plant.dt=0.001"), energy("plant.dt=0.00025"));
    println!("energy off by {coarse:e} J, {fine:e} J with a quarter of the step");
    assert!(fine < 0.4 * coarse && coarse < 0.01, "{coarse} {fine}");
}
