//! Plastic contact never raises the energy: scene 23. Newton's restitution with friction does.

use crate::support::{scene, totals};
use messages::scene::Scene;
use plant::Plant;

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

/// `cargo test --release --test known_answers million -- --ignored` makes a million of them.
fn none_of(count: u32, law: &str) {
    let mut random = fastrand::Rng::with_seed(23);
    let mut scene = impact(&[&format!("plant.law={law}")]);
    let mut lost = 0;
    for i in 0..count {
        let gain = gain(&mut scene, &mut random);
        assert!(gain < 1e-9, "{law}, seed 23: impact {i} raised the energy by {gain:e} of it");
        lost += u32::from(gain < -1e-6);
    }
    println!("{law}: {lost} of {count} impacts took energy");
    assert!(lost > count / 4);
}

#[test]
fn no_plastic_impact_of_a_hundred_thousand_raises_the_energy() {
    none_of(100_000, "Aligned");
    none_of(20_000, "EnergyQp");
    none_of(20_000, "Complementarity");
}

#[test]
#[ignore = "half a minute"]
fn no_plastic_impact_of_a_million_raises_the_energy() {
    none_of(1_000_000, "Aligned");
}

/// Newton's law of impact with friction (Kane & Levinson): some impacts throw the tip back with more than there was.
#[test]
fn newton_s_restitution_raises_the_energy_of_some_impacts() {
    let mut random = fastrand::Rng::with_seed(23);
    let mut scene = impact(&["plant.restitution=0.8"]);
    let raised = (0..10_000).filter(|_| gain(&mut scene, &mut random) > 1e-6).count();
    println!("{raised} of 10000 impacts raised the energy");
    assert!(raised > 10);
}
