//! A load that several links share: Coulomb's law leaves open which wheel carries how much, and the motion depends on it.

use crate::support::{plant, run_steps, totals};
use biped_plant::Plant;
use messages::robot::{Body, Joint, JointKind, Sphere};
use messages::scene::{Base, Initial, Method, Scene};

const G: f64 = 9.81;

/// A trunk of 2 kg on wheels of 0.3 kg and 5 cm radius that turn about y. Each wheel has a place on the trunk [m] and a rate [rad/s].
fn cart(wheels: &[([f64; 3], f64)], inertia: [f64; 3], damping: f64) -> Scene {
    let trunk = Body { name: "trunk".into(), mass: 2.0, size: [0.4, 0.2, 0.1], ..Body::default() };
    let wheel = |k: usize| Body {
        name: format!("wheel {k}"),
        mass: 0.3,
        size: [0.1; 3],
        inertia: Some(inertia),
        spheres: vec![Sphere { at: [0.0; 3], radius: 0.05 }],
        joint: Some(Joint {
            parent: "trunk".into(),
            kind: JointKind::Revolute,
            axis: [0.0, 1.0, 0.0],
            at: wheels[k].0,
            damping,
            ..Joint::default()
        }),
        ..Body::default()
    };
    let rates = wheels.iter().map(|wheel| wheel.1).collect();
    let initial = Initial { clearance: Some(0.0), joint_rates: rates, ..Initial::default() };
    let bodies = std::iter::once(trunk).chain((0..wheels.len()).map(wheel)).collect();
    let mut scene = Scene { initial, bodies, ..Scene::default() };
    scene.plant.drive_inertia = 0.0;
    scene
}

/// Three wheels in a line, the middle one spins backwards. By least norm N₁ − 2N₂ + N₃ = 0, so the middle one carries a third of the weight
/// however the outer ones share the rest, and μ(N₁ − N₂ + N₃) = μmg/3. At last all roll: ω(mr² + 3I) = I Σω₀.
#[test]
fn three_wheels_in_a_line_accelerate_by_a_third_of_the_friction() {
    let (mu, mass, [r, i], spin) = (0.3, 2.9, [0.05, 5e-4], 60.0);
    let wheels = [-0.2, 0.0, 0.2].map(|x| ([x, 0.0, -0.05], if x == 0.0 { -spin } else { spin }));
    let mut scene = cart(&wheels, [3e-4, i, 3e-4], 0.0);
    (scene.plant.base, scene.plant.friction) = (Base::Planar, mu);
    for method in Method::ALL {
        let mut plant = plant(scene.clone(), method, 1e-3);
        run_steps(&mut plant, 10);
        let (speed, expected) = (totals(&plant).com_velocity.x, mu * G / 3.0 * 0.01);
        assert!((speed - expected).abs() < 1e-9, "{method:?}: {speed} m/s after 10 ms instead of {expected}");
        run_steps(&mut plant, 290);
        let (speed, expected) = (totals(&plant).com_velocity.x, r * i * spin / (mass * r * r + 3.0 * i));
        assert!((speed - expected).abs() < 1e-6, "{method:?}: {speed} m/s at last instead of {expected}");
        let report = plant.truth();
        assert!(report.fallbacks == 0 && report.natural_map <= 1e-10, "{method:?}: {report:?}");
    }
}

/// A cart with its wheels listed in an order; its centre of mass, velocity along the ground, turn and the rates of its wheels are at random.
fn four_wheels(friction: f64, com: [f64; 3], motion: [f64; 3], rates: [f64; 4], order: [usize; 4]) -> Scene {
    let places = [[0.2, 0.12, -0.05], [0.2, -0.12, -0.05], [-0.2, 0.12, -0.05], [-0.2, -0.12, -0.05]];
    let mut scene = cart(&order.map(|k| (places[k], rates[k])), [2.25e-4, 3.75e-4, 2.25e-4], 0.02);
    scene.bodies[0].com = com;
    scene.plant.friction = friction;
    scene.initial.velocity = [motion[0], motion[1], 0.0];
    scene.initial.angular_velocity = [0.0, 0.0, motion[2]];
    scene
}

fn speed_after(scene: &Scene, method: Method, dt: f64) -> f64 {
    let mut plant: Plant = plant(scene.clone(), method, dt);
    run_steps(&mut plant, (0.25 / dt).round() as usize);
    totals(&plant).com_velocity.norm()
}

/// The second cart tips onto two wheels and lands on the others. The heights of its wheels then differ by 1e-8 m, the error of the steps.
#[test]
fn a_cart_moves_alike_by_every_method_step_and_order_of_its_wheels() {
    let carts = [
        (0.5, [0.0343, 0.0234, 0.0091], [0.4594, -0.1172, 1.9008], [-11.758, 34.875, -2.032, 19.836], 1e-4),
        (1.5, [0.0675, 0.0136, 0.038], [-1.0148, -0.8262, 2.1206], [3.458, 20.768, -5.747, -2.26], 2e-4),
    ];
    for (friction, com, motion, rates, width) in carts {
        let scene = |order: [usize; 4]| four_wheels(friction, com, motion, rates, order);
        let reference = speed_after(&scene([0, 1, 2, 3]), Method::EventDriven, 1e-3);
        for order in [[0, 1, 2, 3], [3, 2, 1, 0], [1, 3, 0, 2]] {
            for (method, dt) in [
                (Method::MidpointContact, 1e-3),
                (Method::MidpointContact, 5e-4),
                (Method::MidpointContact, 1e-4),
                (Method::StepDoubling, 1e-3),
                (Method::Rk4Impact, 1e-3),
            ] {
                let speed = speed_after(&scene(order), method, dt);
                println!("μ {friction}, {method:?} at {dt} s, {order:?}: {speed:.5} m/s, reference {reference:.5}");
                assert!(
                    (speed - reference).abs() < width,
                    "{method:?} at {dt} s, {order:?}: {speed} for {reference} m/s"
                );
            }
        }
    }
}

/// Carts at random that slide, roll, tip and land again.
#[test]
fn random_carts_move_as_by_the_reference_method() {
    let mut random = fastrand::Rng::with_seed(11);
    let mut errors = vec![];
    for k in 0..40 {
        let mut any = |size: f64| size * (2.0 * random.f64() - 1.0);
        let (com, motion) = ([any(0.08), any(0.04), any(0.04)], [any(1.5), any(1.5), any(8.0)]);
        let rates = [0; 4].map(|_| any(30.0));
        let friction = [0.2, 0.5, 1.0, 1.5][k % 4];
        let scene = four_wheels(friction, com, motion, rates, [0, 1, 2, 3]);
        let reference = speed_after(&scene, Method::EventDriven, 1e-3);
        let error = |dt: f64| (speed_after(&scene, Method::MidpointContact, dt) - reference).abs();
        let (coarse, fine) = (error(1e-3), error(2.5e-4));
        println!("cart {k}, μ {friction}: off by {coarse:.1e} and {fine:.1e} m/s of {reference:.4}");
        errors.push([coarse, fine]);
    }
    let [mut coarse, fine] = [0, 1].map(|k| errors.iter().map(|error| error[k]).collect::<Vec<_>>());
    coarse.sort_by(f64::total_cmp);
    let [median, most] = [coarse[20], fine.into_iter().fold(0.0, f64::max)];
    println!("at 1 ms {median:.1e} in the median and {:.1e} at most, at 0.25 ms {most:.1e} at most", coarse[39]);
    assert!(median < 3e-5 && coarse[38] < 2e-4 && coarse[39] < 0.01 && most < 2e-4);
}
