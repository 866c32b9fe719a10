//! The scenes of the comparison with other simulators that have a closed-form solution. With the paper's method every error is of the order of
//! the step. With the method that each scene names, at no higher cost, it is far smaller. With event detection it is near rounding error.
//! The scenes without a closed-form solution, `turn` and `ball`, are in `smooth.rs`.

use crate::support::{G, assert_near, clearance, plant, pose, run, scene, step, totals};
use nalgebra::Vector3;
use plant::Plant;

/// The paper's method.
const PAPER: &[&str] = &["plant.method=SemiImplicitEuler", "plant.dt=0.001", "rate=1000"];
/// The settings of the scene itself.
const OWN: &[&str] = &[];
/// Event detection.
const BEST: &[&str] = &["plant.method=EventDriven", "plant.dt=0.001", "rate=1000"];

/// Positions of all contact points [m].
fn points(plant: &Plant) -> Vec<Vector3<f64>> {
    let pose = pose(plant);
    plant.model().contact_points.iter().map(|corner| pose.point(corner.link, &corner.at)).collect()
}

/// Mean speed of the fastest contact point in the second half of the scene [m/s].
fn creep(name: &str, settings: &[&str]) -> f64 {
    let duration = scene(name, settings).duration;
    let mut plant = plant(name, settings);
    run(&mut plant, 0.5 * duration);
    let middle = points(&plant);
    run(&mut plant, duration);
    let distance = middle.iter().zip(points(&plant)).map(|(before, after)| (after - before).norm()).fold(0.0, f64::max);
    distance / (0.5 * duration)
}

/// Largest relative changes of energy and angular momentum.
fn flight(settings: &[&str]) -> [f64; 2] {
    let mut plant = plant("free", settings);
    let start = totals(&plant);
    let mut worst = [0.0_f64; 2];
    while plant.time_ns() < 5_000_000_000 {
        step(&mut plant);
        let now = totals(&plant);
        worst[0] = worst[0].max((now.kinetic / start.kinetic - 1.0).abs());
        worst[1] = worst[1].max((now.angular - start.angular).norm() / start.angular.norm());
    }
    worst
}

#[test]
fn free_flight_conserves_energy_and_angular_momentum() {
    for (settings, most) in [(PAPER, 0.02), (OWN, 1e-10), (BEST, 1e-13)] {
        let errors = flight(settings);
        println!("energy, angular momentum: {errors:?}");
        assert!(errors.iter().all(|error| *error < most), "{settings:?}: {errors:?}");
    }
}

/// Errors of the final position of the cube, along and across its initial direction, and its gap to the ground [m].
fn slide(name: &str, degrees: f64, settings: &[&str]) -> [f64; 3] {
    let stop = 2.0 * 2.0 / (2.0 * 0.5 * G);
    assert_near("stop", stop, 0.407_747, 1e-6);
    let mut plant = plant(name, settings);
    run(&mut plant, 1.0);
    let (sin, cos) = degrees.to_radians().sin_cos();
    let com = totals(&plant).com;
    [stop - com.x * cos - com.y * sin, com.y * cos - com.x * sin, clearance(&plant)]
}

#[test]
fn a_cube_slides_straight_and_stops_at_coulombs_distance() {
    for (name, degrees) in [("slide", 0.0), ("slide30", 30.0)] {
        for (settings, most) in [(PAPER, 2e-3), (OWN, 1e-6), (BEST, 1e-6)] {
            let [short, askew, gap] = slide(name, degrees, settings);
            println!("{name}: {short:e} m short, {askew:e} m askew, gap {gap:e} m");
            assert_near(name, short, 0.0, most);
            assert_near("askew", askew, 0.0, 1e-9);
            assert_near("gap", gap, 0.0, 1e-9);
        }
    }
}

#[test]
fn a_cube_slides_down_a_slope_with_constant_acceleration() {
    let slope = 20f64.to_radians();
    let distance = 0.5 * G * (slope.sin() - 0.3 * slope.cos()) * 2.0 * 2.0;
    assert_near("distance", distance, 1.179_404, 1e-6);
    for (settings, most) in [(PAPER, 2e-3), (OWN, 1e-12), (BEST, 1e-7)] {
        let mut plant = plant("incline", settings);
        run(&mut plant, 2.0);
        println!("{:e} m short", distance - totals(&plant).com.x);
        assert_near("distance", totals(&plant).com.x, distance, most);
        assert_near("speed", totals(&plant).com_velocity.x, distance, 1e-9);
    }
}

#[test]
fn a_sticking_cube_does_not_creep() {
    for name in ["stick", "stand0", "stand10"] {
        for settings in [PAPER, OWN, BEST] {
            let creep = creep(name, settings);
            println!("{name} {settings:?}: {creep:e} m/s");
            assert!(creep < 1e-12, "{name} {settings:?}: {creep:e} m/s");
        }
    }
}

#[test]
fn a_foot_lands_without_penetrating_the_ground() {
    for settings in [PAPER, OWN, BEST] {
        let mut plant = plant("drop", settings);
        let mut least = f64::INFINITY;
        while plant.time_ns() < 500_000_000 {
            step(&mut plant);
            least = least.min(clearance(&plant));
        }
        assert_near("lowest", least, 0.0, 1e-12);
        assert_near("at the end", clearance(&plant), 0.0, 1e-12);
    }
}

/// Housner: the impact keeps the fraction 1 - 1.5 sin² α of the angular velocity. The block then rises to the angle of the remaining energy.
#[test]
fn a_rocking_block_rises_to_the_height_that_its_impact_allows() {
    let tipping = 0.25_f64.atan();
    let ratio = 1.0 - 1.5 * tipping.sin().powi(2);
    assert_near("ratio", ratio, 0.911_764_705_882, 1e-12);
    let apex = tipping - (tipping.cos() + ratio * ratio * ((0.5 * tipping).cos() - tipping.cos())).acos();
    for (settings, most) in [(PAPER, 0.04), (OWN, 1e-3), (BEST, 1e-4)] {
        let mut plant = plant("rock", settings);
        let mut top = 0.0_f64;
        while plant.time_ns() < 1_000_000_000 {
            step(&mut plant);
            let axis = pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned();
            top = top.max(-axis.x.atan2(axis.z));
        }
        println!("apex {:e} off", top / apex - 1.0);
        assert_near("apex", top, apex, most * apex);
    }
}

/// Mean speed between two instants at which a spoke is upright [m/s].
fn wheel(settings: &[&str]) -> f64 {
    let mut plant = plant("wheel", settings);
    let eighth = 45f64.to_radians();
    let mut upright = vec![];
    let mut before = [f64::NAN; 3];
    while plant.time_ns() < 4_000_000_000 {
        step(&mut plant);
        // angle since the last such instant
        let axis = pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned();
        let past = (axis.x.atan2(axis.z) + 0.5 * eighth).rem_euclid(eighth);
        let now = [past, plant.time_ns() as f64 * 1e-9, totals(&plant).com.x];
        if past < before[0] {
            let part = (eighth - before[0]) / (eighth - before[0] + past);
            upright.push([1, 2].map(|k| before[k] + part * (now[k] - before[k])));
        }
        before = now;
    }
    let [[t0, x0], .., [t1, x1]] = upright[upright.len() / 2..] else { unreachable!("it stopped: {upright:?}") };
    (x1 - x0) / (t1 - t0)
}

#[test]
fn a_rimless_wheel_keeps_its_speed() {
    for (settings, most) in [(PAPER, 0.02), (OWN, 1e-4), (BEST, 1e-5)] {
        let speed = wheel(settings);
        println!("speed {speed} m/s");
        assert_near("speed", speed, 0.784_571, most);
    }
}
