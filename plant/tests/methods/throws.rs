//! The reference method finishes every throw.

use crate::support::{body, box_corners, corners, energy, plant, run_steps};
use biped_plant::Plant;
use messages::robot::{Body, Sphere};
use messages::scene::{Base, Initial, Law, Method, PlantScene, Scene};
use std::time::Instant;

/// Number of throws; `BIPED_THROWS` sets another.
const THROWS: u64 = 60;

/// A box, a flat foot, a light wheel on balls or a rod, thrown at random, on ground of any friction.
pub fn thrown(random: &mut fastrand::Rng) -> Scene {
    let any = |random: &mut fastrand::Rng, size: f64| size * (2.0 * random.f64() - 1.0);
    let size =
        *random.choice(&[[0.2, 0.1, 0.05], [0.1, 0.1, 0.1], [0.1, 0.1, 0.4], [0.3, 0.02, 0.02]]).expect("a choice");
    let [a, _, c] = size.map(|side: f64| 0.5 * side);
    let mut body = Body { name: "body".into(), mass: 10f64.powf(any(random, 1.5)), size, ..Body::default() };
    if random.u32(0..4) == 0 {
        body.spheres =
            (0..3).map(|k| Sphere { at: [a * (f64::from(k) - 1.0), 0.0, 0.0], radius: 0.5 * c + 0.01 }).collect();
    } else {
        body.contacts = box_corners(size);
    }
    let mut vector = |size: f64| [0; 3].map(|_| any(random, size));
    let initial = Initial {
        clearance: Some(0.05),
        orientation_deg: vector(180.0),
        velocity: vector(2.0),
        angular_velocity: vector(12.0),
        ..Initial::default()
    };
    let friction = *random.choice(&[0.0, 0.2, 0.5, 0.8]).expect("a choice");
    let plant =
        PlantScene { dt: 2e-3, method: Method::EventDriven, base: Base::Quaternion, friction, ..PlantScene::default() };
    Scene { rate: 500.0, duration: 1.0, plant, initial, bodies: vec![body], ..Scene::default() }
}

#[test]
fn random_throws_end_without_error() {
    let throws = std::env::var("BIPED_THROWS").ok().and_then(|count| count.parse().ok()).unwrap_or(THROWS);
    let (mut times, mut lost, mut flagged) = (Vec::new(), Vec::new(), 0);
    for seed in 0..throws {
        let mut scene = thrown(&mut fastrand::Rng::with_seed(seed));
        scene.plant.law = [Law::Cone, Law::Aligned][(seed % 2) as usize];
        let (mut plant, begun) = (Plant::new(&scene).expect("a plant"), Instant::now());
        match (0..500).try_for_each(|_| plant.step()) {
            Ok(()) => {
                times.push(begun.elapsed().as_secs_f64());
                flagged += plant.truth().fallbacks;
            }
            Err(error) => lost.push(format!("seed {seed}, {}: {error}", scene.plant.law)),
        }
    }
    times.sort_by(f64::total_cmp);
    let [middle, most] = [times.len() / 2, times.len() - 1].map(|k| 1e3 * times[k]);
    println!(
        "{} of {throws} end, {flagged} steps flagged; a second takes {middle:.1} ms in the middle, {most:.1} ms at most",
        times.len()
    );
    lost.iter().for_each(|lost| println!("{lost}"));
    assert!(lost.is_empty(), "{} throws break off", lost.len());
    assert!(flagged * 50 <= throws, "{flagged} steps of {throws} throws were flagged");
}

/// A foot slides and spins on its sole, and comes to rest at the same place in steps of 5 ms and of 1 ms. It did not settle.
#[test]
fn a_foot_that_slides_and_spins_is_finished_by_the_reference_method() {
    let sole = [[0.1, 0.05], [0.1, -0.05], [-0.1, 0.05], [-0.1, -0.05]].map(|[x, y]| [x, y, -0.025]);
    for law in [Law::Cone, Law::Aligned, Law::Facets(8)] {
        let end = [5e-3, 1e-3].map(|dt| {
            let mut scene = body([0.2, 0.1, 0.05], sole.into());
            (scene.plant.gravity, scene.plant.friction, scene.plant.law) = (9.81, 0.5, law);
            (scene.initial.clearance, scene.initial.velocity) = (Some(0.0), [1.0, 0.0, 0.0]);
            scene.initial.angular_velocity = [0.0, 0.0, 10.0];
            let mut plant = plant(scene, Method::EventDriven, dt);
            run_steps(&mut plant, (1.0 / dt).round() as usize);
            assert!(plant.state().xdot.iter().all(|rate| rate.abs() < 1e-9), "{law}: {:?}", plant.state().xdot);
            corners(&plant)
        });
        let apart = end[0].iter().zip(&end[1]).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        println!("{law}: the front corner ends at {:.6}, {apart:.1e} m apart", end[0][0]);
        assert!(apart < 1e-6, "{law}: {apart} m");
    }
}

/// The robot of Table 1 without torques, thrown at random. Its joints make centrifugal forces significant.
fn thrown_robot(random: &mut fastrand::Rng) -> Scene {
    let mut any = |size: f64| size * (2.0 * random.f64() - 1.0);
    let initial = Initial {
        clearance: Some(0.02),
        orientation_deg: [0; 3].map(|_| any(30.0)),
        velocity: [0; 3].map(|_| any(1.0)),
        joints: (0..8).map(|_| any(0.8)).collect(),
        joint_rates: (0..8).map(|_| any(4.0)).collect(),
        ..Initial::default()
    };
    let plant = PlantScene { dt: 1e-3, ..PlantScene::default() };
    Scene { rate: 1000.0, duration: 1.0, initial, plant, ..Scene::default() }
}

/// After a landing, the rest of a step may be as short as rounding. A velocity change by contact, divided by that time, is no acceleration:
/// with it, the mean velocity of the next step had a hundred times the total energy.
#[test]
fn landings_add_no_energy() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let mut most = 0.0_f64;
    for _ in 0..THROWS {
        let mut plant = Plant::new(&thrown_robot(&mut random)).expect("a plant");
        let start = energy(&plant);
        let mut last = start;
        for _ in 0..700 {
            plant.step().expect("a step");
            let now = energy(&plant);
            most = most.max((now - last) / start);
            last = now;
        }
    }
    println!("most energy made by a step: {most:.1e} of the whole");
    assert!(most < 5e-4); // 2e-4 in 6,000 throws: the error of fast joints
}
