//! Claims about a body that starts inside the ground, under every method.

use crate::support::{body, corners, gap, missing_moment, plant, run_steps};
use biped_plant::Plant;
use biped_plant::detect::lasting_depth;
use messages::scene::{Method, Scene};

/// [m/s²].
const G: f64 = 9.81;

/// A cube of 10 cm whose lowest corners start at this depth [m].
fn cube(depth: f64) -> Scene {
    let corner = |k: usize| [0, 1].map(|axis| if k >> axis & 1 == 0 { 0.05 } else { -0.05 });
    let contacts = (0..4).map(|k| [corner(k)[0], corner(k)[1], -0.05]).collect();
    let mut scene = body([0.1; 3], contacts);
    (scene.plant.gravity, scene.plant.friction) = (G, 0.3);
    scene.initial.position = [0.0, 0.0, 0.05 - depth];
    scene
}

/// Greatest upward speed of a corner that is inside the ground, and greatest height of the lowest corner, over a number of steps.
fn rise(plant: &mut Plant, dt: f64, steps: usize) -> [f64; 2] {
    let (mut fastest, mut highest, mut before) = (0.0_f64, f64::NEG_INFINITY, corners(plant));
    for _ in 0..steps {
        run_steps(plant, 1);
        let now = corners(plant);
        let inside = now.iter().zip(&before).filter(|(now, _)| now.z < 0.0);
        fastest = inside.map(|(now, before)| (now.z - before.z) / dt).fold(fastest, f64::max);
        (highest, before) = (highest.max(gap(plant)), now);
    }
    [fastest, highest]
}

/// The limit is the speed of a free fall of ten steps. Methods whose contact stages span half a step reach half of it.
#[test]
fn no_method_throws_a_body_that_starts_deep_inside_the_ground() {
    for (depth, dt) in [(0.03, 1e-3), (0.1, 1e-3), (0.5, 1e-3), (0.03, 5e-3), (0.5, 5e-3)] {
        let limit = 10.0 * G * dt;
        for method in Method::ALL {
            let mut plant = plant(cube(depth), method, dt);
            let [fastest, highest] = rise(&mut plant, dt, ((2.0 * depth / limit + 0.5) / dt) as usize);
            let end = gap(&plant);
            println!("{method:?}, {depth} m, {dt} s: {fastest:.4} m/s, up to {highest:.1e} m, ends at {end:.1e} m");
            assert!(fastest < 1.001 * limit, "{method:?}: {fastest} m/s from {depth} m with {dt} s");
            assert!(fastest > 0.49 * limit, "{method:?}: the limit is not reached: {fastest} m/s");
            assert!(highest < 50.0 * G * dt * dt, "{method:?}: up to {highest} m from {depth} m with {dt} s");
            assert!(end.abs() < 10.0 * G * dt * dt, "{method:?}: ends at {end} m from {depth} m with {dt} s");
        }
    }
}

/// While it turns, a corner may be somewhat faster than the one that is pushed.
#[test]
fn no_method_throws_a_tilted_body_either() {
    let dt = 1e-3;
    for method in Method::ALL {
        let mut scene = cube(0.1);
        scene.initial.orientation_deg = [10.0, 25.0, 0.0];
        let mut plant = plant(scene, method, dt);
        let [fastest, highest] = rise(&mut plant, dt, 2500);
        println!("{method:?}: {fastest:.4} m/s, up to {highest:.1e} m, ends at {:.1e} m", gap(&plant));
        assert!(
            fastest < 1.5 * 10.0 * G * dt && highest < 50.0 * G * dt * dt,
            "{method:?}: {fastest} m/s, {highest} m"
        );
    }
}

/// Some methods stop velocities only, and leave a small penetration. It is a thousandth of the model's length at most, also where steps are long
/// and gravity is strong.
#[test]
fn a_penetration_up_to_the_lasting_depth_stays_and_a_greater_one_does_not() {
    for (dt, gravity) in [(1e-3, G), (0.01, 100.0 * G)] {
        for method in Method::ALL {
            let scene = |depth: f64| {
                let mut scene = cube(depth);
                (scene.plant.method, scene.plant.dt, scene.plant.gravity) = (method, dt, gravity);
                scene
            };
            let lasting = lasting_depth(&scene(0.0).plant, Plant::new(&scene(0.0)).expect("a plant").model());
            let after = |depth: f64| {
                let mut plant = plant(scene(depth), method, dt);
                run_steps(&mut plant, 1000);
                -gap(&plant)
            };
            let [shallow, deep, least] = [0.8 * lasting, 4.0 * lasting, 1e-6].map(after);
            println!(
                "{method:?}, {dt} s, {gravity} m/s²: {lasting:.1e} m last; of .8 times as much {shallow:.1e} m, of 4 times {deep:.1e} m, of 1e-6 m \
                 {least:.1e} m"
            );
            assert!(lasting < 2e-4, "{method:?}: {lasting} m of a cube of .1 m");
            assert!((shallow - 0.8 * lasting).abs() < 1e-9, "{method:?}: {shallow} m, not {} m", 0.8 * lasting);
            assert!(deep <= 1.001 * lasting + 1e-12, "{method:?}: {deep} m stay, not {lasting} m");
            assert_eq!(least > 0.999e-6, lasting > 0.0, "{method:?}: {least} m");
        }
    }
}

/// Bodies with a point far below their sole, which starts deep in the ground, slide and are brought out. Forces act where the points are: with
/// the arms of the points about the centre of mass they explain the change of angular momentum in each step.
#[test]
fn forces_act_at_the_true_places_of_points_that_are_deep_in_the_ground() {
    let seed = 7;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let dt = 1e-3;
    for trial in 0..12 {
        let mut draw = |from: f64, to: f64| from + (to - from) * random.f64();
        let mut contacts: Vec<_> =
            [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]].map(|[x, y]| [0.1 * x, 0.05 * y, -0.05]).into();
        contacts.push([draw(-0.15, 0.15), draw(-0.1, 0.1), -0.05 - draw(0.02, 0.3)]);
        let mut scene = body([0.2, 0.1, 0.1], contacts);
        (scene.plant.gravity, scene.plant.friction) = (G, draw(0.1, 0.5));
        scene.initial.position = [0.0, 0.0, 0.05];
        scene.initial.velocity = [draw(-2.0, 2.0), draw(-2.0, 2.0), 0.0];
        for method in Method::ALL {
            let mut plant = plant(scene.clone(), method, dt);
            let (worst, loaded) = missing_moment(&mut plant, 60);
            println!("trial {trial}, {method:?}: up to {worst:.1e} of the moment is missing, loaded in {loaded} steps");
            assert!(worst < 2e-3 && loaded == 60, "trial {trial}, {method:?}: {worst:e}, {loaded} steps");
        }
    }
}
