//! Claims: no simulation step allocates heap memory, from the first one on, except under some laws for comparison; nor does a controller tick once
//! the robot walks.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;

use allocation_counter::measure;
use common::scene;
use controller::Controller;
use messages::load::{SCENES, built_in};
use messages::scene::{Law, Method, Scene};
use plant::Plant;

/// Number of allocations of plant and controller in a walk, from control period `warm` to `end`.
fn allocations(scene: &Scene, warm: u32, end: u32) -> [u64; 2] {
    let mut plant = Plant::new(scene).expect("a good scene");
    let mut controller = Controller::new(scene).expect("a good scene");
    let mut encoders = plant.encoders();
    let mut counts = [0; 2];
    for period in 0..end {
        let mut torques = Default::default();
        let tick = measure(|| torques = controller.tick(&encoders).expect("a tick"));
        let step = measure(|| encoders = plant.advance(&torques).expect("a step"));
        if period >= warm {
            counts[0] += step.count_total;
            counts[1] += tick.count_total;
        }
    }
    assert!(controller.telemetry().steps > 8, "the robot has to walk while allocations are counted");
    counts
}

#[test]
fn steps_and_ticks_allocate_nothing_during_the_walk() {
    let mut all = vec![];
    for law in ["plant.law=Cone", "plant.law=EnergyQp", "plant.law=Complementarity", "plant.law=Aligned"] {
        for rule in ["controller.sagittal=foot-placement", "controller.sagittal=energy"] {
            let counts = allocations(&scene("walk", &[law, rule]), 1000, 5000);
            println!("{law} {rule}: {counts:?} allocations of plant and controller in 4 s");
            all.push(counts);
        }
    }
    all.push(allocations(&scene("walk", &["plant.law=Aligned", "controller.rate_limit=4"]), 1000, 5000));
    assert!(all.iter().all(|counts| *counts == [0, 0]), "{all:?}");
}

/// Allocations of the plant in the first 0.2 s of a scene, or until the run ends; `None` if the scene refuses the method.
fn allocations_from_start(scene: &Scene) -> Option<u64> {
    let mut plant = Plant::new(scene).ok()?;
    let mut controller = scene.controller.as_ref().map(|_| Controller::new(scene).expect("a controller"));
    let mut count = 0;
    for _ in 0..(scene.duration.min(0.2) * scene.rate).round() as usize {
        let encoders = plant.encoders();
        let torques = controller.as_mut().map(|controller| controller.tick(&encoders).unwrap_or_default());
        let mut ended = false;
        let step = measure(|| ended = plant.advance(&torques.unwrap_or_default()).is_err());
        if ended {
            break; // an error holds a copy of its problem
        }
        count += step.count_total;
    }
    Some(count)
}

/// The scenes in which the plant allocates after this change, with the number of allocations.
fn scenes_that_allocate(change: impl Fn(&mut Scene)) -> Vec<(&'static str, u64)> {
    let counted = SCENES.iter().filter_map(|(name, _)| {
        let mut scene = built_in(name).expect("a scene");
        change(&mut scene);
        Some((*name, allocations_from_start(&scene)?))
    });
    counted.filter(|(_, count)| *count > 0).collect()
}

#[test]
fn no_step_of_any_scene_and_method_allocates() {
    for method in Method::ALL {
        let scenes = scenes_that_allocate(|scene| scene.plant.method = method);
        assert!(scenes.is_empty(), "{method:?}: {scenes:?}");
    }
}

/// Whether a law may allocate in a step: laws for comparison by programs of other libraries, or of a size that is not known in advance.
fn may_allocate(law: Law) -> bool {
    match law {
        Law::Lagged | Law::Facets(_) | Law::ConeQp | Law::FixedPoint(_) => true,
        Law::Cone | Law::Aligned | Law::Complementarity | Law::EnergyQp | Law::EnergyQpGap => false,
        Law::SpringDamper | Law::Sweep(_) => false,
    }
}

#[test]
fn no_step_of_any_scene_and_law_allocates_except_of_laws_for_comparison() {
    for law in Law::ALL {
        let scenes = scenes_that_allocate(|scene| scene.plant.law = law);
        assert_eq!(!scenes.is_empty(), may_allocate(law), "{law}: {scenes:?}");
    }
}

#[test]
fn the_allocation_counter_counts() {
    assert_eq!(measure(|| drop(std::hint::black_box(Vec::<u8>::with_capacity(10)))).count_total, 1);
}
