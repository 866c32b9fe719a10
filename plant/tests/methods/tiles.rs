//! Uneven ground: contact points meet the tile under them.

use crate::support::{body, corners, missing_moment, plant, run_steps};
use biped_plant::{Plant, PlantError};
use messages::robot::Sphere;
use messages::scene::{Base, Ground, GroundTile, Law, Method, RandomTiles, Scene};
use std::ops::Range;

/// Corners of the bottom of a box of .2 × .1 × .1 m [m].
const SOLE: [[f64; 3]; 4] = [[0.1, 0.05, -0.05], [0.1, -0.05, -0.05], [-0.1, 0.05, -0.05], [-0.1, -0.05, -0.05]];

const G: f64 = 9.81;
const LOCATING: [Method; 2] = [Method::Rk4Impact, Method::EventDriven];
/// The methods that stop a point where it lands.
const LANDING: [Method; 4] = [Method::MidpointContact, Method::StepDoubling, Method::Rk4Impact, Method::EventDriven];

/// A tile over a range of x, for all y.
fn tile(x: Range<f64>, height: f64) -> GroundTile {
    GroundTile { x: [x.start, x.end], y: [-10.0, 10.0], height }
}

/// A point mass on these tiles, at a height above the ground and with a speed along x.
fn point(tiles: Vec<GroundTile>, clearance: f64, speed: f64) -> Scene {
    let mut scene = body([0.1; 3], vec![[0.0, 0.0, -0.05]]);
    (scene.plant.base, scene.plant.gravity, scene.plant.friction) = (Base::Planar, G, 0.0);
    scene.plant.ground.tiles = tiles;
    (scene.initial.clearance, scene.initial.velocity) = (Some(clearance), [speed, 0.0, 0.0]);
    scene
}

fn height(plant: &Plant) -> f64 {
    corners(plant)[0].z
}

#[test]
fn a_body_that_slides_over_a_step_down_falls_freely_and_lands_on_the_lower_tile() {
    let edge = 0.1003; // within a step
    for (method, depth) in Method::ALL.into_iter().flat_map(|method| [(method, 0.05), (method, 0.01)]) {
        let mut plant = plant(point(vec![tile(edge..9.0, -depth)], 0.0, 1.0), method, 1e-3);
        run_steps(&mut plant, 99);
        let on_top = height(&plant).abs();
        let falling = (500.0 * (2.0 * depth / G).sqrt()).round(); // steps, half of the fall
        run_steps(&mut plant, 1 + falling as usize); // at 1 m/s it passes the edge after .1003 s
        let since_edge = 1e-3 * (100.0 + falling) - edge;
        let fall = (height(&plant) + 0.5 * G * since_edge.powi(2)).abs();
        run_steps(&mut plant, 150);
        let landed = (height(&plant) + depth).abs();
        println!("{method:?}, {depth} m: {on_top:e} m on top, {fall:e} m in the fall, {landed:e} m landed");
        let (fall_limit, landed_limit) = match method {
            Method::Rk4Impact | Method::EventDriven => (1e-9, 1e-9),
            Method::MidpointContact => (1.1e-3 * G * since_edge, 1e-9), // it notices the edge one step late
            Method::StepDoubling => (1.1e-3 / 256.0 * G * since_edge, 1e-9), // one of its shortest parts late
            _ => (2.1e-3 * G * since_edge, 1.1e-3 * (2.0 * G * depth).sqrt()),
        };
        assert!(on_top < 1e-12 && fall < fall_limit && landed < landed_limit, "{method:?}, {depth} m");
    }
}

/// A point that carried load on the upper tile carries none in the fall: it is stopped when it lands, and not before.
#[test]
fn a_body_that_falls_from_a_step_meets_no_force_before_it_lands() {
    let (edge, dt) = (0.1003, 1e-3);
    for (method, depth) in LANDING.into_iter().flat_map(|method| (1..40).map(move |k| (method, 0.0005 * f64::from(k))))
    {
        let mut plant = plant(point(vec![tile(edge..9.0, -depth)], 0.0, 1.0), method, dt);
        run_steps(&mut plant, 101);
        let (mut steps, mut speed) = (101, 0.0);
        while height(&plant) + depth > 1e-9 {
            speed = -plant.state().xdot[1];
            let late = speed - G * (f64::from(steps) * dt - edge);
            assert!(late < 1e-9 && late > -1.1 * G * dt, "{method:?}, {depth} m: {late} m/s too fast");
            run_steps(&mut plant, 1);
            steps += 1;
        }
        assert!((speed / (2.0 * G * depth).sqrt() - 1.0).abs() < 0.2, "{method:?}, {depth} m: it lands at {speed} m/s");
    }
}

/// Its front corners are beyond the edge first, so it tips, and slides on over the edge on its rear corners.
#[test]
fn a_sole_that_slides_over_a_step_down_lies_flat_on_the_lower_tile() {
    let (depth, dt) = (0.01_f64, 1e-3);
    for method in Method::ALL {
        let mut scene = point(vec![tile(0.1003..9.0, -depth)], 0.0, 1.0);
        scene.plant.base = Base::Quaternion;
        scene.bodies[0].contacts = SOLE.to_vec();
        let mut plant = plant(scene, method, dt);
        run_steps(&mut plant, 350);
        let off = corners(&plant).iter().map(|corner| (corner.z + depth).abs()).fold(0.0, f64::max);
        println!("{method:?}: {off:e} m");
        let limit = if LANDING.contains(&method) { 1e-9 } else { 1.1 * dt * (2.0 * G * depth).sqrt() };
        assert!(off < limit, "{method:?}: {off:e} m");
    }
}

#[test]
fn a_body_stands_on_a_tile_at_the_height_of_the_tile() {
    let mut scene = body([0.2, 0.1, 0.1], SOLE.to_vec());
    scene.plant.gravity = G;
    scene.plant.ground.tiles = vec![tile(-1.0..1.0, 0.013)];
    scene.initial.clearance = Some(0.0);
    let rests = |scene: &Scene, method: Method, what: &str| {
        let mut plant = plant(scene.clone(), method, 1e-3);
        let start = corners(&plant);
        run_steps(&mut plant, 500);
        let moved = corners(&plant).iter().zip(&start).map(|(a, b)| (a - b).norm()).fold(0.0, f64::max);
        let load: f64 = plant.truth().contact_force.iter().skip(2).step_by(3).sum();
        assert!(start.iter().all(|corner| (corner.z - 0.013).abs() < 1e-15), "{what}: {start:?}");
        assert!(moved < 1e-9 && (load / G - 1.0).abs() < 1e-6, "{what}: {moved:e} m, {load} N");
    };
    for method in Method::ALL {
        rests(&scene, method, &format!("{method:?}"));
    }
    for law in ["Aligned", "Facets(8)", "FixedPoint(Tresca)", "Complementarity", "EnergyQp", "ConeQp", "Lagged"] {
        scene.plant.law = law.parse().expect("a law");
        rests(&scene, Method::MidpointContact, law);
    }
}

#[test]
fn a_body_across_an_edge_rests_on_both_tiles() {
    let mut scene = body([0.2, 0.1, 0.1], SOLE.to_vec());
    scene.plant.gravity = G;
    scene.plant.ground.tiles = vec![tile(0.0..1.0, 0.01)];
    scene.initial.clearance = Some(0.0);
    for method in Method::ALL {
        let mut plant = plant(scene.clone(), method, 5e-4);
        run_steps(&mut plant, 2000);
        let off = |corner: &nalgebra::Vector3<f64>| (corner.z - if corner.x > 0.0 { 0.01 } else { 0.0 }).abs();
        let most = corners(&plant).iter().map(off).fold(0.0, f64::max);
        println!("{method:?}: {most:e} m");
        assert!(most < 1e-5, "{method:?}: {most:e} m from the tiles");
    }
}

/// A swinging foot, for example. It leaves the tile at most at the speed of a point that begins inside the ground.
#[test]
fn a_point_that_flies_into_a_higher_tile_is_lifted_slowly() {
    let (step, dt) = (0.01, 1e-3);
    for method in Method::ALL {
        let mut plant = plant(point(vec![tile(0.05..9.0, step)], 0.02, 1.0), method, dt);
        let (mut fastest, mut highest, mut deepest, mut before) = (0.0_f64, 0.0_f64, 0.0_f64, height(&plant));
        for _ in 0..500 {
            run_steps(&mut plant, 1);
            fastest = fastest.max((height(&plant) - before) / dt);
            before = height(&plant);
            (highest, deepest) = (highest.max(before), deepest.max(plant.truth().penetration));
        }
        println!("{method:?}: {fastest} m/s, up to {highest} m, {deepest} m deep, at last at {before} m");
        assert!(deepest > 0.2 * step, "{method:?} does not enter the tile");
        assert!(fastest < 10.5 * G * dt + 0.03, "{method:?}: {fastest} m/s");
        assert!(highest < 0.02 + 1e-9 && (before - step).abs() < 1e-4, "{method:?}: {highest}, {before}");
    }
}

#[test]
fn a_point_that_slides_into_a_higher_tile_keeps_its_height() {
    for method in Method::ALL {
        let mut plant = plant(point(vec![tile(0.05..0.2, 0.01)], 0.0, 1.0), method, 1e-3);
        for step in 0..300 {
            run_steps(&mut plant, 1);
            assert!(height(&plant).abs() < 1e-9, "{method:?}: {} m in step {step}", height(&plant));
        }
    }
}

#[test]
fn tiles_of_height_zero_give_the_bits_of_the_plane() {
    let chequered = || {
        let places = (-20..20).map(|i| (f64::from(i) * 0.1, f64::from(i + 1) * 0.1));
        places.map(|(from, to)| tile(from..to, 0.0)).collect()
    };
    for name in ["slide30", "drop", "rock", "wheel", "stand10"] {
        for method in Method::ALL {
            let hash = |tiles: Vec<GroundTile>| {
                let mut scene = crate::support::built_in(name);
                scene.plant.ground.tiles = tiles;
                let mut plant = plant(scene, method, 1e-3);
                run_steps(&mut plant, 400);
                plant.truth().hash
            };
            assert_eq!(hash(chequered()), hash(vec![]), "{name}, {method:?}");
        }
    }
}

#[test]
fn a_restored_run_continues_with_the_same_bits() {
    for method in Method::ALL {
        let mut scene = point(vec![tile(0.05..0.2, 0.01)], 0.0, 1.0);
        scene.plant.ground.random = RandomTiles { height: 0.005, ..RandomTiles::default() };
        let mut plant = plant(scene, method, 1e-3);
        run_steps(&mut plant, 100); // inside the tile, at the height from which it came
        let snapshot = plant.snapshot();
        let end = |plant: &mut Plant| {
            run_steps(plant, 200);
            plant.truth().hash
        };
        let first = end(&mut plant);
        plant.restore(&snapshot);
        assert_eq!(end(&mut plant), first, "{method:?}");
    }
}

#[test]
fn springs_refuse_uneven_ground_and_accept_the_plane() {
    let mut scene = point(vec![tile(0.0..1.0, 0.01)], 0.0, 0.0);
    scene.plant.law = Law::SpringDamper;
    let error = Plant::new(&scene).map(|_| ()).expect_err("refused");
    assert!(matches!(&error, PlantError::Value { .. }) && error.to_string().contains("plant.ground"), "{error}");
    scene.plant.ground = Ground::default();
    assert!(Plant::new(&scene).is_ok());
}

/// Crossing the edge of a tile is an event, so a long step changes nothing.
#[test]
fn event_methods_locate_edges() {
    for method in LOCATING {
        let end = |dt: f64| {
            let mut plant = plant(point(vec![tile(0.1234..9.0, -0.05)], 0.0, 1.0), method, dt);
            run_steps(&mut plant, (0.4 / dt).round() as usize);
            (height(&plant), plant.counts().events)
        };
        let [(short, events), (long, same)] = [end(1e-3), end(0.02)];
        println!("{method:?}: {short} and {long} m, {events} and {same} events");
        assert!((short - long).abs() < 1e-9 && events == same && events < 4, "{method:?}");
    }
}

/// A ball with its centre of mass below its middle, with 0.7 J of motion, rolls over edges of tiles that rise. It carries load all the time, so it keeps
/// the height that it rolls on, and moves as on level ground.
#[test]
fn a_ball_that_rolls_under_load_onto_higher_tiles_moves_as_on_level_ground() {
    let ball = |tiles: Vec<GroundTile>, friction: f64| {
        let mut scene = body([0.2; 3], vec![]);
        scene.bodies[0].spheres = vec![Sphere { at: [0.0; 3], radius: 0.1 }];
        (scene.bodies[0].com, scene.bodies[0].inertia) = ([0.0, 0.0, -0.04], Some([0.002; 3]));
        (scene.plant.gravity, scene.plant.friction, scene.plant.ground.tiles) = (G, friction, tiles);
        (scene.initial.clearance, scene.initial.orientation_deg) = (Some(0.0), [0.0, -143.2394, 0.0]);
        scene
    };
    let stairs = |first: f64| {
        (0..20).map(|k| tile(first + 0.02 * f64::from(k)..first + 0.02 * f64::from(k + 1), 0.01)).collect()
    };
    for (method, dt) in
        [Method::MidpointContact, Method::StepDoubling, Method::SemiImplicitEuler, Method::MidpointMoreau]
            .into_iter()
            .flat_map(|method| [5e-3, 2.5e-3, 1e-3].map(|dt| (method, dt)))
    {
        for (friction, first) in [(1.0, 0.02), (1.0, 0.11), (0.2, 0.07)] {
            let [level, uneven] = [vec![], stairs(first)].map(|tiles| {
                let mut plant = plant(ball(tiles, friction), method, dt);
                run_steps(&mut plant, (1.0 / dt) as usize);
                plant.state().clone()
            });
            let apart = level.x.iter().zip(&uneven.x).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(apart < 1e-9, "{method:?}, {dt} s, μ = {friction}, from {first} m: {apart:e} m");
        }
    }
}

/// A sole stands across an edge, with corners at two heights, and is pushed along the ground by less than friction holds. Friction at the
/// higher corners has a shorter arm than friction at the lower ones.
#[test]
fn forces_on_a_sole_across_an_edge_balance_its_moments() {
    let step = 0.04;
    let tilt = f64::asin(step / 0.2);
    for method in Method::ALL {
        for push in [[2.0, 0.0], [-2.0, 1.0], [0.0, 2.0]] {
            let mut scene = body([0.2, 0.1, 0.1], SOLE.into());
            (scene.plant.gravity, scene.plant.friction) = (G, 0.8);
            scene.plant.ground.tiles = vec![tile(0.0..9.0, step)];
            scene.initial.orientation_deg = [0.0, -tilt.to_degrees(), 0.0];
            let lift = 0.05 * tilt.cos() + 0.5 * step; // the middle of the sole is half a step high
            scene.initial.position = [-0.05 * tilt.sin(), 0.0, lift];
            let mut plant = plant(scene, method, 1e-3);
            assert!(plant.push(0, [0.05 * push[0], 0.05 * push[1], 0.0], 0.05));
            let (worst, loaded) = missing_moment(&mut plant, 50);
            let moved = plant.state().xdot.iter().fold(0.0_f64, |most, v| most.max(v.abs()));
            println!("{method:?}, {push:?}: {worst:.1e} of the moment is missing in {loaded} steps, {moved:.1e} m/s");
            assert!(worst < 1e-6 && loaded == 50 && moved < 1e-3, "{method:?}, {push:?}: {worst:e}, {moved:e}");
        }
    }
}
