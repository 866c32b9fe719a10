//! Plastic contact never raises the energy: scene 23. Newton's restitution with friction does.

use crate::support::{scene, totals};
use messages::scene::Scene;
use plant::Plant;
use rayon::prelude::*;

/// Impacts of one seed.
const BATCH: u64 = 1000;

/// Energy that a random impact of a double pendulum's tip on the floor gives, in parts of the energy before it.
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

/// An impact of no duration: no gravity, a step of a picosecond, the tip on the floor.
fn impact(settings: &[&str]) -> Scene {
    let still = ["plant.gravity=0", "plant.dt=1e-12", "rate=1e12", "duration=1e-6", "initial.clearance=0.0"];
    scene("double-pendulum", &[&still[..], settings].concat())
}

/// Impacts with seeds of their own, on all cores.
fn none_of(count: u64, law: &str) {
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
fn no_plastic_impact_of_a_million_raises_the_energy() {
    none_of(1_000_000, "Aligned");
    none_of(20_000, "EnergyQp");
    none_of(20_000, "Complementarity");
}

/// Newton's law of impact with friction (Kane & Levinson) throws some tips back with more than there was. Its coefficient is lowered there, so
/// none does; with the whole of it some would.
#[test]
fn no_impact_with_restitution_raises_the_energy() {
    let mut random = fastrand::Rng::with_seed(23);
    let mut scene = impact(&["plant.restitution=0.8"]);
    let gains: Vec<f64> = (0..10_000).map(|_| gain(&mut scene, &mut random)).collect();
    let (raised, most) = (gains.iter().filter(|gain| **gain > 1e-6).count(), gains.iter().copied().fold(0.0, f64::max));
    println!("{raised} of 10000 impacts raised the energy, the most by {most:e} J");
    assert!(most < 1e-7, "{most:e} J");
}
