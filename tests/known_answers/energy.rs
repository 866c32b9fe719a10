//! Plastic impacts never raise the energy: scene 23. Newton's law of restitution with friction can.

use crate::support::{scene, totals};
use messages::scene::Scene;
use plant::Plant;
use rayon::prelude::*;

/// Number of impacts with one seed.
const BATCH: u64 = 1000;

/// Relative energy gain of a random impact of the tip of a double pendulum on the floor.
fn gain(scene: &mut Scene, random: &mut fastrand::Rng) -> f64 {
    let mut number = |size: f64| size * (2.0 * random.f64() - 1.0);
    scene.initial.joints = vec![number(3.1), number(3.1)];
    scene.initial.joint_rates = vec![number(10.0), number(10.0)];
    scene.plant.friction = number(1.0).abs() * 2.0;
    let mut plant = Plant::new(scene).expect("a pendulum");
    let before = totals(&plant).kinetic;
    plant.step().expect("a step");
    totals(&plant).kinetic / before - 1.0
}

/// An impact without duration: no gravity, a step of one picosecond, the tip on the floor.
fn impact(settings: &[&str]) -> Scene {
    let still = ["plant.gravity=0", "plant.dt=1e-12", "rate=1e12", "duration=1e-6", "initial.clearance=0.0"];
    scene("double-pendulum", &[&still[..], settings].concat())
}

/// Asserts that no random impact gains energy. Each batch has its own seed; batches run on all cores.
fn assert_no_gain(count: u64, law: &str) {
    let scene = impact(&[&format!("plant.law={law}")]);
    let impacts = |batch: u64| {
        let (mut scene, mut random) = (scene.clone(), fastrand::Rng::with_seed(batch));
        let gains = (0..BATCH).map(|i| {
            let gain = gain(&mut scene, &mut random);
            assert!(gain < 1e-9, "{law}, seed {batch}: impact {i} raised the energy by {gain:e} of it");
            usize::from(gain < -1e-6)
        });
        gains.sum::<usize>()
    };
    let lost: usize = (0..count / BATCH).into_par_iter().map(impacts).sum();
    println!("{law}: {lost} of {count} impacts took energy");
    assert!(lost as u64 > count / 4);
}

#[test]
fn none_of_a_million_plastic_impacts_raises_the_energy() {
    assert_no_gain(1_000_000, "Aligned");
    assert_no_gain(20_000, "EnergyQp");
    assert_no_gain(20_000, "Complementarity");
}

/// With friction, Newton's law of impact can raise the energy (Kane & Levinson). The plant reduces the coefficient of restitution in such impacts,
/// so no impact does.
#[test]
fn no_impact_with_restitution_raises_the_energy() {
    let mut random = fastrand::Rng::with_seed(23);
    let mut scene = impact(&["plant.restitution=0.8"]);
    let gains: Vec<f64> = (0..10_000).map(|_| gain(&mut scene, &mut random)).collect();
    let (raised, most) = (gains.iter().filter(|gain| **gain > 1e-6).count(), gains.iter().copied().fold(0.0, f64::max));
    println!("{raised} of 10000 impacts raised the energy, the most by {most:e} J");
    assert!(most < 1e-7, "{most:e} J");
}
