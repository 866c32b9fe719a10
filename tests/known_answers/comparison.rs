//! The ten scenes on which engines are compared, with the default law and method: every error is of the order of the step.

use crate::support::{G, assert_near, clearance, plant, pose, run, scene, step, totals};
use nalgebra::Vector3;
use plant::Plant;

const H: f64 = 1e-3;

/// Where each contact point is [m].
fn points(plant: &Plant) -> Vec<Vector3<f64>> {
    let pose = pose(plant);
    plant.model().corners.iter().map(|corner| pose.point(corner.link, &corner.at)).collect()
}

/// Speed of the contact point that moved most in the second half of the scene [m/s].
fn creep(name: &str) -> f64 {
    let duration = scene(name, &[]).duration;
    let mut plant = plant(name, &[]);
    run(&mut plant, 0.5 * duration);
    let middle = points(&plant);
    run(&mut plant, duration);
    let way = middle.iter().zip(points(&plant)).map(|(before, after)| (after - before).norm()).fold(0.0, f64::max);
    way / (0.5 * duration)
}

#[test]
fn free_flight_keeps_energy_and_angular_momentum() {
    let mut plant = plant("free", &[]);
    let start = totals(&plant);
    let (mut energy, mut angular) = (0.0_f64, 0.0_f64);
    while plant.time_ns() < 5_000_000_000 {
        step(&mut plant);
        let now = totals(&plant);
        energy = energy.max((now.kinetic / start.kinetic - 1.0).abs());
        angular = angular.max((now.angular - start.angular).norm() / start.angular.norm());
    }
    println!("energy {energy:e}, angular momentum {angular:e}");
    assert!(energy < 0.02 && angular < 0.02);
}

#[test]
fn a_cube_slides_straight_and_stops_where_coulomb_says() {
    let stop = 2.0 * 2.0 / (2.0 * 0.5 * G);
    assert_near("stop", stop, 0.407_747, 1e-6);
    for (name, ahead) in [("slide", 0.0_f64), ("slide30", 30.0)] {
        let mut plant = plant(name, &[]);
        run(&mut plant, 1.0);
        let (sin, cos) = ahead.to_radians().sin_cos();
        let com = totals(&plant).com;
        println!("{name}: {:e} m short, {:e} m askew", stop - com.x * cos - com.y * sin, com.y * cos - com.x * sin);
        assert_near(name, com.x * cos + com.y * sin, stop, 2.0 * H);
        assert_near("askew", com.y * cos - com.x * sin, 0.0, 1e-12);
        assert_near("gap", clearance(&plant), 0.0, 1e-12);
    }
}

#[test]
fn a_cube_slides_down_a_slope_by_the_law_of_falling() {
    let slope = 20f64.to_radians();
    let acceleration = G * (slope.sin() - 0.3 * slope.cos());
    assert_near("distance", 2.0 * acceleration, 1.179_404, 1e-6);
    let mut plant = plant("incline", &[]);
    run(&mut plant, 2.0);
    assert_near("distance", totals(&plant).com.x, 2.0 * acceleration, 2.0 * H * acceleration);
    assert_near("speed", totals(&plant).com_velocity.x, 2.0 * acceleration, 1e-11);
}

#[test]
fn what_sticks_does_not_creep() {
    for (name, most) in [("stick", 1e-12), ("stand0", 1e-9), ("stand10", 1e-9)] {
        let creep = creep(name);
        println!("{name}: {creep:e} m/s");
        assert!(creep < most, "{name}: {creep:e} m/s");
    }
}

#[test]
fn a_foot_lands_on_the_ground_and_not_in_it() {
    let mut plant = plant("drop", &[]);
    let mut least = f64::INFINITY;
    while plant.time_ns() < 500_000_000 {
        step(&mut plant);
        least = least.min(clearance(&plant));
    }
    assert_near("lowest", least, 0.0, 1e-12);
    assert_near("at the end", clearance(&plant), 0.0, 1e-12);
}

/// Housner: the spin after the impact is 1 - 1.5 sin² of it, so the block rises to the angle of that energy.
#[test]
fn a_rocking_block_rises_as_far_as_its_impact_leaves_it() {
    let tipping = 0.25_f64.atan();
    let ratio = 1.0 - 1.5 * tipping.sin().powi(2);
    assert_near("ratio", ratio, 0.911_764_705_882, 1e-12);
    let apex = tipping - (tipping.cos() + ratio * ratio * ((0.5 * tipping).cos() - tipping.cos())).acos();
    let mut plant = plant("rock", &[]);
    let mut top = 0.0_f64;
    while plant.time_ns() < 1_000_000_000 {
        step(&mut plant);
        let axis = pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned();
        top = top.max(-axis.x.atan2(axis.z));
    }
    println!("apex {:e} off", top / apex - 1.0);
    assert_near("apex", top, apex, 0.04 * apex);
}

#[test]
fn a_wheel_without_a_rim_keeps_its_speed() {
    let mut plant = plant("wheel", &[]);
    let mut upright = vec![];
    let mut before = f64::NAN;
    while plant.time_ns() < 4_000_000_000 {
        step(&mut plant);
        // how far the wheel has turned past the last place in which a spoke is upright
        let (axis, eighth) =
            (pose(&plant).links[plant.model().base_link].rotation.column(2).into_owned(), 45f64.to_radians());
        let past = (axis.x.atan2(axis.z) + 0.5 * eighth).rem_euclid(eighth);
        if past < before {
            upright.push((plant.time_ns() as f64 * 1e-9, totals(&plant).com.x));
        }
        before = past;
    }
    let [(t0, x0), .., (t1, x1)] = upright[upright.len() / 2..] else { unreachable!("it stopped: {upright:?}") };
    let speed = (x1 - x0) / (t1 - t0);
    println!("speed {speed} m/s");
    assert_near("speed", speed, 0.784_571, 0.01);
}
