//! Contact: landing, stopping, resting, rolling about a foot.

use crate::support::{body, built_in, corners, distance, gap, ground_distance, plant, run_steps, totals};
use biped_plant::{Plant, PlantError};
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Law, Method, Scene};

const LOCATING: [Method; 2] = [Method::Rk4Impact, Method::EventDriven];

#[test]
fn a_sliding_block_stops_within_the_error_of_the_method() {
    let exact = 4.0 / (2.0 * 0.5 * 9.81);
    for name in ["slide", "slide30"] {
        for method in Method::ALL {
            let mut plant = plant(built_in(name), method, 1e-3);
            let start = totals(&plant).com;
            run_steps(&mut plant, 600);
            let error = (ground_distance(&start, &totals(&plant).com) / exact - 1.0).abs();
            println!("{name} {method:?}: {error:e}");
            let limit = match method {
                Method::ExplicitEuler | Method::SemiImplicitEuler => 3e-3, // v h/2
                Method::MoreauJean
                | Method::MidpointMoreau
                | Method::MidpointContact
                | Method::Rk4
                | Method::ImplicitMidpoint => 5e-6,
                Method::StepDoubling => 1e-7,
                Method::Rk4Impact | Method::EventDriven => 1e-12,
            };
            assert!(error < limit, "{name} {method:?}: {error:e}");
        }
    }
}

#[test]
fn a_falling_body_stops_at_the_ground_if_the_impact_is_located() {
    for method in LOCATING {
        for dt in [0.02, 0.001] {
            let mut plant = plant(built_in("drop"), method, dt);
            let (mut lowest, mut hop) = (f64::INFINITY, 0.0_f64);
            for step in 0..(0.5 / dt) as usize {
                run_steps(&mut plant, 1);
                lowest = lowest.min(gap(&plant));
                if step as f64 * dt > 0.15 {
                    hop = hop.max(gap(&plant));
                }
            }
            println!("{method:?} {dt}: lowest {lowest:e} m, highest after landing {hop:e} m, {:?}", plant.counts());
            assert!(lowest > -1e-12 && hop < 1e-12 && plant.counts().events == 1, "{method:?}");
        }
    }
}

#[test]
fn a_resting_body_neither_creeps_nor_sinks_under_any_method() {
    for method in Method::ALL {
        let mut plant = plant(built_in("stick"), method, 1e-3);
        let start = corners(&plant);
        run_steps(&mut plant, 1000);
        let moved = corners(&plant).iter().zip(&start).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let counts = plant.counts();
        println!("{method:?}: {moved:e} m in 1 s, {counts:?}");
        assert!(moved < 1e-13, "{method:?}: {moved:e}");
        assert!(counts.warm as f64 > 0.98 * counts.contacts as f64, "it reuses its active set: {counts:?}");
    }
}

/// A mass on a massless leg of .8 m that turns about its foot at 1 rad/s.
fn inverted_pendulum() -> Scene {
    let mut scene = crate::support::body([0.02; 3], vec![[0.0, 0.0, -0.8]]);
    (scene.plant.base, scene.plant.gravity, scene.plant.friction) = (Base::Planar, 9.81, 1.0);
    scene.initial.clearance = Some(0.0);
    (scene.initial.angular_velocity, scene.initial.velocity) = ([0.0, 1.0, 0.0], [0.8, 0.0, 0.0]);
    scene
}

#[test]
fn an_inverted_pendulum_keeps_its_foot_on_the_ground() {
    for method in Method::ALL {
        let mut plant = plant(inverted_pendulum(), method, 1e-3);
        let start = totals(&plant);
        let (mut drift, mut slip) = (0.0_f64, 0.0_f64);
        for _ in 0..400 {
            run_steps(&mut plant, 1);
            drift = drift.max(gap(&plant).abs());
            slip = slip.max(corners(&plant)[0].x.abs());
        }
        let end = totals(&plant);
        let energy = (end.kinetic + end.potential - start.kinetic - start.potential).abs() / start.kinetic;
        println!("{method:?}: gap {drift:e} m, slip {slip:e} m, energy {energy:e} after .4 s");
        let limits = match method {
            Method::EventDriven => [1e-12, 1e-12, 1e-10],
            Method::Rk4Impact => [1e-10, 1e-10, 1e-8],
            _ => [1e-3, 1e-2, 0.1],
        };
        let found = [drift, slip, energy];
        assert!(found.iter().zip(limits).all(|(found, limit)| *found < limit), "{method:?}: {found:?}");
    }
}

#[test]
fn rolling_contact_reduces_the_order_of_impulse_methods_only() {
    let mut exact = plant(inverted_pendulum(), Method::EventDriven, 0.02);
    run_steps(&mut exact, 20);
    for method in Method::ALL {
        let error = |dt: f64| {
            let mut plant = plant(inverted_pendulum(), method, dt);
            run_steps(&mut plant, (0.4 / dt).round() as usize);
            distance(&plant, &exact)
        };
        let errors = [0.01, 0.005, 0.0025].map(error);
        let order = (errors[0] / errors[2]).log2() / 2.0;
        println!("{method:?}: errors {errors:?}, order {order:.2}");
        match method {
            Method::EventDriven => assert!(errors[0] < 1e-11, "{errors:?}"),
            Method::Rk4Impact => assert!(order > 3.6 && errors[0] < 1e-5, "{order}: {errors:?}"),
            Method::StepDoubling => assert!(errors[0] < 1e-3, "{errors:?}"),
            _ => assert!(order > 0.7, "{method:?} is of order {order}: {errors:?}"),
        }
    }
}

#[test]
fn the_reference_is_the_same_at_two_tolerances_and_steps() {
    let run = |name: &str, tolerance: f64, dt: f64| -> Plant {
        let mut scene = built_in(name);
        scene.plant.tolerance_step = tolerance;
        let mut plant = plant(scene, Method::EventDriven, dt);
        run_steps(&mut plant, (1.0 / dt).round() as usize);
        plant
    };
    for name in ["rock", "wheel", "slide30", "stand0"] {
        let [loose, tight] = [run(name, 1e-9, 0.01), run(name, 1e-12, 0.004)];
        let error = distance(&loose, &tight);
        println!("{name}: differ by {error:e}; {:?} and {:?}", loose.counts(), tight.counts());
        assert!(error < 1e-7, "{name}: {error:e}");
    }
}

#[test]
fn event_methods_refuse_laws_without_contact_forces() {
    for method in LOCATING {
        for law in [Law::EnergyQp, Law::SpringDamper] {
            let mut scene = built_in("drop");
            (scene.plant.method, scene.plant.law) = (method, law);
            let error = Plant::new(&scene).map(|_| ()).expect_err("refused");
            assert!(matches!(&error, PlantError::Value { .. }) && error.to_string().contains("Aligned"), "{error}");
        }
    }
}

#[test]
fn no_method_allocates_after_the_first_contact() {
    for method in Method::ALL {
        for name in ["drop", "stand0"] {
            let mut plant = plant(built_in(name), method, 1e-3);
            run_steps(&mut plant, 300);
            let taken = allocation_counter::measure(|| run_steps(&mut plant, 100)).count_total;
            assert_eq!(taken, 0, "{method:?} in {name}");
        }
    }
}

/// A box that lands tilted, and then slides on its sole: each corner carries its share of the load. The two methods that only stop velocities
/// at the end of a step leave one corner above the ground, by less than g h²: the others are as deep inside it, and such a depth is not recovered.
#[test]
fn a_box_that_slides_after_its_landing_rests_on_all_four_corners() {
    let sole = vec![[0.1, 0.05, -0.025], [0.1, -0.05, -0.025], [-0.1, 0.05, -0.025], [-0.1, -0.05, -0.025]];
    let mut scene = body([0.2, 0.2, 0.02], sole);
    scene.bodies[0].inertia = Some([0.003, 0.004, 0.005]);
    (scene.plant.gravity, scene.plant.friction) = (9.81, 0.3);
    (scene.initial.clearance, scene.initial.velocity) = (Some(0.0), [1.5, 0.4, 0.0]);
    (scene.initial.angular_velocity, scene.initial.orientation_deg) = ([0.0, 0.0, 3.0], [2.0, 3.0, 0.0]);
    for method in Method::ALL {
        let mut plant = plant(scene.clone(), method, 1e-3);
        run_steps(&mut plant, 300);
        let loads = [2, 5, 8, 11].map(|z| plant.truth().contact_force[z]);
        let highest = corners(&plant).iter().fold(f64::NEG_INFINITY, |most, corner| most.max(corner.z));
        println!("{method:?}: {loads:.3?} N, the highest corner is at {highest:.1e} m");
        if [Method::SemiImplicitEuler, Method::MoreauJean].contains(&method) {
            assert!(loads.contains(&0.0) && highest > 1e-12 && highest < 9.81e-6, "{method:?}: {loads:?}");
        } else {
            // those of the reference
            let most =
                loads.iter().zip([2.547, 2.715, 2.190, 2.358]).fold(0.0_f64, |most, (a, b)| most.max((a - b).abs()));
            assert!(most < 0.005, "{method:?}: {loads:?}");
        }
    }
}

/// A pendulum on a pedestal that is bolted to the world, with contact points in the ground on the pedestal and on the axis of the joint.
#[test]
fn contact_points_that_no_joint_moves_never_touch() {
    let pendulum = |points: Vec<[f64; 3]>| {
        let mut scene = body([0.2; 3], points.clone());
        (scene.plant.base, scene.plant.gravity) = (Base::Fixed, 9.81);
        scene.initial.position[2] = -0.05;
        scene.initial.joints = vec![0.3];
        let joint = Joint {
            parent: scene.bodies[0].name.clone(),
            kind: JointKind::Revolute,
            axis: [0.0, 1.0, 0.0],
            at: [0.0; 3],
            stiffness: 0.0,
            damping: 0.0,
            rest: 0.0,
        };
        let on_axis = points.iter().map(|_| [0.0, 0.1, 0.0]).collect();
        let arm =
            Body { name: "arm".into(), mass: 1.0, size: [0.1, 0.1, 0.3], com: [0.0, 0.0, 0.2], ..Body::default() };
        scene.bodies.push(Body { joint: Some(joint), contacts: on_axis, ..arm });
        scene
    };
    for method in Method::ALL {
        let run = |points| {
            let mut plant = plant(pendulum(points), method, 1e-3);
            run_steps(&mut plant, 300);
            plant
        };
        let [with, without] = [vec![[0.1, 0.1, -0.1], [-0.1, 0.1, -0.1]], vec![]].map(run);
        assert_eq!(with.state(), without.state(), "{method:?}");
        assert_eq!(with.counts().contacts, 0, "{method:?}");
    }
}
