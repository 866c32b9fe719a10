//! Restitution: bounces, their end, and bodies that rested before.

use crate::support::{built_in, gap, plant, run_steps};
use biped_plant::Plant;
use messages::load::parse;
use messages::scene::Method;

const G: f64 = 9.81;

/// A foot that falls flat from .1 m and leaves the ground with `e` times its landing speed, and its time to fall.
fn dropped(e: f64, method: Method, dt: f64) -> (Plant, f64) {
    let mut scene = built_in("drop");
    scene.plant.restitution = e;
    (plant(scene, method, dt), (2.0 * 0.1 / G).sqrt())
}

fn rise(plant: &Plant) -> f64 {
    plant.state().xdot[2]
}

const BOUNCING: [Method; 4] =
    [Method::SemiImplicitEuler, Method::MidpointContact, Method::Rk4Impact, Method::EventDriven];

/// There are infinitely many bounces, but their sum is finite: t (1 + 2e/(1 − e)), with t the time to fall.
#[test]
fn a_bouncing_foot_lies_still_after_the_sum_of_its_bounces() {
    for method in BOUNCING {
        for e in [0.5, 0.8] {
            let dt = 1e-4;
            let (mut plant, fall) = dropped(e, method, dt);
            let sum = fall * (1.0 + 2.0 * e / (1.0 - e));
            let mut last = 0.0;
            for step in 0..(1.2 * sum / dt) as usize {
                run_steps(&mut plant, 1);
                if plant.state().xdot.iter().any(|v| v.abs() > 2.0 * G * dt) {
                    last = (step + 1) as f64 * dt;
                }
            }
            println!("{method:?}, e = {e}: still after {last:.4} s, the sum is {sum:.4} s; {:e}", rise(&plant));
            assert!((last / sum - 1.0).abs() < 0.01, "{method:?}, e = {e}: {last} instead of {sum}");
            // The bounces that are cut off are no faster than two steps of free fall, and the ball falls for one more step.
            assert!(gap(&plant).abs() < 2.5 * G * dt * dt, "{method:?}: {:e}", gap(&plant));
            assert!(rise(&plant).abs() < 1e-6, "{method:?}: {:e}", rise(&plant));
        }
    }
}

/// A contact no faster than two steps of free fall does not bounce. After the sum of the bounces and some steps, nothing moves.
#[test]
fn bounces_end() {
    let dt = 1e-3;
    for method in BOUNCING {
        for e in [0.3, 0.8, 0.95] {
            let (mut plant, fall) = dropped(e, method, dt);
            let sum = fall * (1.0 + 2.0 * e / (1.0 - e));
            run_steps(&mut plant, (1.03 * sum / dt) as usize + 30);
            let moves = plant.state().xdot.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            println!("{method:?}, e = {e}: {moves:e} m/s");
            assert!(moves < 1e-6, "{method:?}, e = {e}: {moves:e} m/s");
        }
    }
}

/// Cf. matter-js #305: wherever within a step a ball meets the ground, it leaves with the speed it came with. By a method that did not find the
/// time of its landing, three of 150 balls stopped.
#[test]
fn a_ball_bounces_from_every_height() {
    let text = "[plant]\nfriction = 0.0\nrestitution = 1.0\n[initial]\nclearance = 0.05\n[[bodies]]\nname = \"ball\"\nmass = 1.0\n\
        size = [0.2, 0.2, 0.2]\ninertia = [0.004, 0.004, 0.004]\nspheres = [{ at = [0.0, 0.0, 0.0], radius = 0.1 }]\n";
    let scene = parse(text, "a test").expect("a scene");
    for method in BOUNCING.into_iter().chain([Method::StepDoubling]) {
        let mut worst = 0.0_f64;
        for k in 0..150 {
            let mut scene = scene.clone();
            scene.initial.clearance = Some(0.05 + 2e-5 * f64::from(k));
            let mut plant = plant(scene, method, 1e-3);
            let start = gap(&plant);
            run_steps(&mut plant, 130);
            assert!(rise(&plant) > 0.5, "{method:?}, {start} m: {} m/s", rise(&plant));
            let apex = gap(&plant) + rise(&plant).powi(2) / (2.0 * G);
            worst = worst.max((apex - start).abs());
        }
        println!("{method:?}: apex off by up to {worst:.1e} m");
        let limit = if method == Method::SemiImplicitEuler { 2e-3 } else { 1e-9 }; // v h
        assert!(worst < limit, "{method:?}: {worst} m");
    }
}

/// Elastic: after a hundred bounces it still rises as high.
#[test]
fn elastic_bounces_keep_their_height() {
    for method in [Method::MidpointContact, Method::StepDoubling, Method::Rk4Impact, Method::EventDriven] {
        let (mut plant, fall) = dropped(1.0, method, 2e-3);
        let mut highest = 0.0_f64;
        run_steps(&mut plant, (200.0 * fall / 2e-3) as usize);
        for _ in 0..(2.5 * fall / 2e-3) as usize {
            run_steps(&mut plant, 1);
            highest = highest.max(gap(&plant) + rise(&plant).powi(2) / (2.0 * G));
        }
        println!("{method:?}: {:e} of .1 m", highest - 0.1);
        assert!((highest - 0.1).abs() < 1e-9, "{method:?}: {highest} m");
    }
}

#[test]
fn methods_that_do_not_find_a_landing_refuse_restitution() {
    for method in Method::ALL.into_iter().filter(|method| !method.bounces()) {
        let mut scene = built_in("drop");
        (scene.plant.restitution, scene.plant.method) = (0.5, method);
        let refusal = Plant::new(&scene).err().map(|error| error.to_string()).unwrap_or_default();
        let asked = [format!("{method:?}"), "plant.restitution".into(), "MidpointContact".into()];
        assert!(asked.iter().all(|word| refusal.contains(word)), "{method:?}: {refusal}");
    }
}

/// A body that rested, is thrown up and falls again bounces as it did the first time.
#[test]
fn a_resting_foot_bounces_again_when_it_falls_again() {
    let e = 0.5;
    for method in BOUNCING {
        let (mut plant, _) = dropped(e, method, 1e-3);
        let mut bounce = |what: &str| {
            let mut landing = 0.0;
            for _ in 0..1000 {
                let before = rise(&plant);
                run_steps(&mut plant, 1);
                if before < -0.5 && rise(&plant) > before {
                    landing = before;
                    break;
                }
            }
            println!("{method:?}, {what}: {landing} m/s, then {} m/s", rise(&plant));
            assert!(landing < -0.5, "it lands");
            // e multiplies the speed at the instant of detection
            let known = if method == Method::SemiImplicitEuler { 1e-12 } else { G * 1e-3 };
            assert!((rise(&plant) + e * landing).abs() < known, "{method:?}, {what}: {} of {landing}", rise(&plant));
            run_steps(&mut plant, 1000);
            assert!(rise(&plant).abs() < 1e-7, "it lies still: {:e}", rise(&plant));
            assert!(plant.push(0, [0.0, 0.0, 2.0], 0.01), "a foot");
            run_steps(&mut plant, 10);
        };
        ["dropped", "thrown", "thrown again"].into_iter().for_each(&mut bounce);
    }
}

/// Eight limbs of a fixed base fall side by side, each a little higher than the last, and land one after another within a step.
#[test]
fn limbs_that_land_one_after_another_within_a_step_all_bounce() {
    let (e, lowest) = (0.7, 0.5);
    for (h, apart) in [(1e-3, 4e-4), (1e-3, 1e-4), (5e-3, 3e-3), (1e-2, 3e-3)] {
        let heights: Vec<f64> = (0..8).map(|i| lowest + apart * f64::from(i)).collect();
        let limbs: String = (heights.iter().enumerate())
            .map(|(i, height)| {
                format!(
                    "[[bodies]]\nname = \"{i}\"\nmass = 1.0\nsize = [0.1, 0.1, 0.2]\ncontacts = [[0.0, 0.0, -0.1]]\n\
                     joint = {{ parent = \"base\", kind = \"prismatic\", axis = [0.0, 0.0, 1.0], at = [{}, 0.0, {}] }}\n",
                    0.3 * i as f64,
                    height - 2.9
                )
            })
            .collect();
        let text = format!(
            "[plant]\nbase = \"fixed\"\nrestitution = {e}\n[initial]\nposition = [0.0, 0.0, 3.0]\n\
             [[bodies]]\nname = \"base\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n{limbs}"
        );
        for method in [Method::MidpointContact, Method::StepDoubling, Method::Rk4Impact, Method::EventDriven] {
            let mut plant = plant(parse(&text, "a test").expect("a scene"), method, h);
            run_steps(&mut plant, (0.6 / h).round() as usize);
            for (height, x) in heights.iter().zip(&plant.state().x) {
                let fall = (2.0 * height / G).sqrt();
                let (speed, time) = (e * G * fall, 0.6 - fall);
                let expected = speed * time - 0.5 * G * time * time - height;
                assert!((x - expected).abs() < 1e-6, "{method:?}, h = {h}: {x} m instead of {expected}");
            }
            assert_eq!(plant.truth().fallbacks, 0, "{method:?}, h = {h}");
        }
    }
}
