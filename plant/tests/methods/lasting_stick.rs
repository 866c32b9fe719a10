//! A rod pivots about its tip on a steep slope, so fast that the tip would rise without contact. Friction presses it to the ground. Coulomb's law
//! allows both motions, and the one that continues the step before is taken.

use crate::support::{corners, plant, run_steps, totals};
use biped_plant::Plant;
use messages::robot::Body;
use messages::scene::{Method, Scene};

/// Inclination of the ground, and of the rod against its normal.
const SLOPE_DEG: f64 = 45.0;
const LEAN_DEG: f64 = -30.0;
/// Half the length of the rod [m].
const HALF: f64 = 0.5;
/// Rate about the tip at the start [rad/s].
const RATE: f64 = 3.7;

/// A rod that stands on `points` at one of its ends.
fn rod(points: Vec<[f64; 3]>) -> Scene {
    let body =
        Body { name: "rod".into(), mass: 1.0, size: [0.02, 0.02, 2.0 * HALF], contacts: points, ..Body::default() };
    let mut scene = Scene { bodies: vec![body], ..Scene::default() };
    (scene.plant.friction, scene.plant.drive_inertia, scene.plant.incline_deg) = (3.0, 0.0, SLOPE_DEG);
    let (sin, cos) = LEAN_DEG.to_radians().sin_cos();
    scene.initial.clearance = Some(0.0);
    scene.initial.orientation_deg = [0.0, LEAN_DEG, 0.0];
    scene.initial.angular_velocity = [0.0, RATE, 0.0];
    scene.initial.velocity = [RATE * HALF * cos, 0.0, -RATE * HALF * sin];
    scene
}

/// Upward acceleration of the tip without contact: ω² l cos(lean) − g cos(slope) [m/s²].
fn free_rise(plant: &Plant) -> f64 {
    let (totals, tip) = (totals(plant), corners(plant)[0]);
    let rate = totals.com_velocity.norm() / HALF; // the tip is at rest
    rate * rate * (totals.com - tip).z + plant.model().gravity.z
}

/// The four methods that locate landings let go of the tip at the same time, on one contact and on two. The others lift or lower a point that
/// pivots by half of h² times its acceleration in each step, so they may lose it.
#[test]
fn a_tip_that_sticks_stays_where_it_would_rise_without_contact() {
    let tip = |y: f64| [0.0, y, -HALF];
    for points in [vec![tip(0.0)], vec![tip(-0.01), tip(0.01)]] {
        let mut exact = None;
        for (method, dt) in [
            (Method::EventDriven, 1e-3),
            (Method::Rk4Impact, 1e-3),
            (Method::StepDoubling, 1e-3),
            (Method::MidpointContact, 2e-4),
            (Method::MidpointContact, 1e-3),
            (Method::MidpointContact, 5e-3),
        ] {
            let mut plant = plant(rod(points.clone()), method, dt);
            let start = corners(&plant)[0];
            assert!(free_rise(&plant) < 0.0, "it presses on the ground at first");
            let count = |time: f64| (time / dt).round() as usize;
            run_steps(&mut plant, count(0.05));
            let (rise, moved) = (free_rise(&plant), (corners(&plant)[0] - start).norm());
            println!(
                "{method:?}, {dt} s, {} points: {rise:.3} m/s² without contact, moved {moved:.1e} m",
                points.len()
            );
            assert!(rise > 0.3 && moved < 1e-5, "{method:?}, {dt} s: {rise} m/s², {moved} m");
            run_steps(&mut plant, count(0.05));
            let left = (corners(&plant)[0] - start).norm();
            let exact = *exact.get_or_insert(left); // by the first method
            println!("  after twice the time {left:.6} m");
            assert!((left - exact).abs() < 0.05 * exact, "{method:?}, {dt} s: {left} m instead of {exact} m");
        }
    }
}
