//! Sliding and sticking without lift-off: scenes 1, 2, 3 and 20; and the walk before its first step.

use crate::support::{G, advance, assert_near, clearance, load, plant, pose, position, run, scene, step, totals};
use controller::Controller;
use messages::scene::Law;
use plant::Plant;

/// The integration method of the paper, which the closed forms assume.
const EULER: &str = "plant.method=SemiImplicitEuler";
/// The laws that are exactly Coulomb's for straight slip.
const COULOMB: [Law; 2] = [Law::Complementarity, Law::Aligned];

#[test]
fn a_block_slides_to_a_stop_with_its_front_loaded_more() {
    let (mu, weight, h) = (0.5, G, 1e-3);
    for law in COULOMB {
        let mut plant = plant("sliding-block", &[&format!("plant.law={law}")]);
        for k in 1..=300 {
            advance(&mut plant);
            let v = f64::max(0.0, 1.0 - mu * G * h * f64::from(k));
            assert_near("v", totals(&plant).com_velocity.x, v, 1e-13);
            assert_near("gap", clearance(&plant), 0.0, 1e-14);
            let [front, back] = [0, 1].map(|i| load(&plant, i).z);
            assert_near("normal force", front + back, weight, 1e-10);
            if v > 0.0 {
                assert_near("front", front, 0.5 * (1.0 + mu * 0.1 / 0.2) * weight, 1e-10);
                assert_near("back", back, 0.5 * (1.0 - mu * 0.1 / 0.2) * weight, 1e-10);
            }
        }
    }
}

/// The printed QP throws the block upward. With the gap in the QP, the block glides μ v h above the ground, unless it is thrown upward first.
#[test]
fn a_sliding_block_leaves_the_ground_under_the_energy_qps() {
    let mut thrown = plant("sliding-block", &["plant.law=EnergyQp", EULER]);
    let mut highest = 0.0_f64;
    for _ in 0..100 {
        step(&mut thrown);
        highest = highest.max(clearance(&thrown));
    }
    assert_near("hop", highest, hop(1.0, 1e-3), 1e-12);
    let mut gliding = plant("sliding-block", &["plant.law=EnergyQpGap", "initial.clearance=0.0005", EULER]);
    for _ in 0..150 {
        step(&mut gliding);
        let v = totals(&gliding).com_velocity.x;
        assert_near("gap", clearance(&gliding), 0.5 * v * 1e-3, 1e-9);
        assert!(v > 0.0);
    }
}

/// Height to which the printed QP throws a point that slides at v with μ = 0.5. The point leaves upward at μ v_F, v_F = (v - μ g h)/(1 + μ²).
fn hop(v: f64, h: f64) -> f64 {
    let thrown = 0.5 * (v - 0.5 * G * h) / 1.25;
    (0..).map(|k| (thrown - f64::from(k) * G * h) * h).take_while(|rise| *rise > 0.0).sum()
}

#[test]
fn a_fast_cube_neither_lifts_nor_tumbles() {
    let mut cube = plant("fast-cube", &[]);
    step(&mut cube);
    assert_near("v after one step", totals(&cube).com_velocity.x, 5.975_48, 6e-6);
    for _ in 1..400 {
        assert_near("gap", clearance(&cube), 0.0, 1e-13);
        assert_near("spin", totals(&cube).angular.norm(), 0.0, 1e-13);
        step(&mut cube);
    }
    let mut thrown = plant("fast-cube", &["plant.law=EnergyQp", EULER]);
    let mut highest = 0.0_f64;
    for _ in 0..400 {
        step(&mut thrown);
        highest = highest.max(totals(&thrown).com.z - 0.05);
    }
    println!("the printed program lifts it {:.1} mm", 1e3 * highest);
    assert_near("hop", highest, hop(6.0, 5e-3), 1e-9);
    assert_near("hop", highest, 0.291, 0.01);
}

/// Slopes from 3° to 40°, with friction angles .01 rad above and below the slope.
#[test]
fn a_block_sticks_or_slides_with_the_acceleration_of_the_slope() {
    for degrees in 3..=40 {
        let slope = f64::from(degrees).to_radians();
        for (spare, law) in [(0.01, Law::Aligned), (-0.01, Law::Aligned), (0.01, Law::Complementarity)] {
            let mu = (slope + spare).tan();
            let settings =
                [format!("plant.incline_deg={degrees}"), format!("plant.friction={mu}"), format!("plant.law={law}")];
            let mut plant = plant("slope", &settings.each_ref().map(String::as_str));
            let start = position(&plant);
            run(&mut plant, 0.5);
            let gain = if spare > 0.0 { 0.0 } else { G * (slope.sin() - mu * slope.cos()) };
            assert_near("speed", totals(&plant).com_velocity.x, 0.5 * gain, 1e-12);
            let way = (position(&plant) - start).norm();
            assert_near("way", way, 0.5 * gain * 0.25, 1e-12);
        }
    }
}

#[test]
fn a_block_on_springs_creeps_down_a_slope_that_holds_it() {
    let mut plant = plant("slope", &["plant.friction=0.374", "plant.law=SpringDamper", "plant.dt=0.0001"]);
    run(&mut plant, 0.5);
    let speed = totals(&plant).com_velocity.x;
    println!("creep {:.0} µm/s", 1e6 * speed);
    assert!(speed > 50e-6, "{speed}");
}

#[test]
fn a_cube_sticks_for_an_hour_inside_its_friction_cone() {
    let mut plant = plant("stick-hour", &[]);
    let start = position(&plant);
    run(&mut plant, 3600.0);
    let way = (position(&plant) - start).norm();
    println!("moved {way:e} m in an hour");
    assert!(way <= 1e-9);
}

/// The legs have no hip roll, so both move in parallel planes at a distance of the hip width. With two flat soles and a roll angle φ of the
/// trunk, the soles are width/cos φ apart. The robot can therefore sway on both feet only if they slide. Where friction prevents that, they tip:
/// slightly, from μ = .67.
#[test]
fn a_robot_without_hip_roll_spreads_its_feet_while_swaying() {
    let (off, tipped, roll) = sway("0.6");
    println!("rolled by {roll:.4} rad; off by {off:.1e} m, corners {tipped:.1e} m up");
    assert_near("roll", roll, 0.05, 0.01);
    assert_near("width", off, 0.0, 1e-9);
    assert_near("highest corner", tipped, 0.0, 1e-7);
    let (off, tipped, roll) = sway("1.5");
    let growth = HIPS / roll.cos() - HIPS;
    println!("held: {off:.1e} m of {growth:.1e} m lacking, corners {tipped:.1e} m up");
    assert!(off > 0.9 * growth && tipped > growth, "held by friction");
}

/// Distance of the hips [m].
const HIPS: f64 = 0.1;

/// The walk until it lifts a foot: largest deviation from that distance [m], largest height of a contact point [m], and largest roll of the
/// trunk [rad].
fn sway(friction: &str) -> (f64, f64, f64) {
    let scene = scene("walk", &[&format!("plant.friction={friction}")]);
    let mut plant = Plant::new(&scene).expect("a robot");
    let mut controller = Controller::new(&scene).expect("a controller");
    let (mut off, mut highest, mut most) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..1250 {
        let torques = controller.tick(&plant.encoders()).expect("a tick");
        plant.advance(&torques).expect("a period");
        let (model, pose) = (plant.model(), pose(&plant));
        let corners: Vec<_> = model.contact_points.iter().map(|corner| pose.point(corner.link, &corner.at)).collect();
        let [left, right] = [0, 4].map(|first| corners[first..first + 4].iter().map(|at| at.y).sum::<f64>() / 4.0);
        let roll = pose.links[model.base_link].rotation.column(1).z.asin();
        off = off.max((left - right - HIPS / roll.cos()).abs());
        highest = corners.iter().fold(highest, |highest, at| highest.max(at.z));
        most = most.max(roll.abs());
    }
    (off, highest, most)
}
