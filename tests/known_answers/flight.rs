//! Without contact: scenes 16, 17 and 19.

use crate::support::{assert_near, plant, pose, run, scene, spin, step, totals};
use messages::scene::Base;
use nalgebra::{Rotation3, Vector3};
use plant::Plant;
use std::f64::consts::PI;

/// Period of the angular velocity in the body frame: 4 K(m)/p, from the elliptic functions of Euler's top. K comes from the arithmetic-geometric
/// mean.
fn period(moments: [f64; 3], spin: [f64; 3]) -> f64 {
    let mut order = [0, 1, 2];
    order.sort_by(|&a, &b| moments[b].total_cmp(&moments[a])); // largest first
    let [i1, i2, i3] = order.map(|k| moments[k]);
    let sum = |power: i32| (0..3).map(|k| moments[k].powi(power) * spin[k] * spin[k]).sum::<f64>();
    let (double_energy, momentum) = (sum(1), sum(2));
    // the axis about which the angular momentum precesses
    let (i1, i3) = if momentum > double_energy * i2 { (i1, i3) } else { (i3, i1) };
    let rate = ((i1 - i2) * (momentum - double_energy * i3) / (i1 * i2 * i3)).sqrt();
    let modulus = (i2 - i3) * (double_energy * i1 - momentum) / ((i1 - i2) * (momentum - double_energy * i3));
    let (mut a, mut b) = (1.0, (1.0 - modulus).sqrt());
    while f64::abs(a - b) > 1e-15 {
        (a, b) = (0.5 * (a + b), f64::sqrt(a * b));
    }
    4.0 * PI / (2.0 * a) / rate
}

/// Angular velocity of the base in the body frame.
fn body_rate(plant: &Plant) -> Vector3<f64> {
    pose(plant).links[plant.model().base_link].rotation.transpose() * spin(plant)
}

/// Errors after one period, with a step that divides the period: angular velocity, energy, and angular momentum.
fn tumble(method: &str, steps: u32) -> [f64; 3] {
    let mut scene = scene("spinning-box", &[&format!("plant.method={method}")]);
    let exact = period(scene.bodies[0].moments(), scene.initial.angular_velocity);
    assert_near("period", exact, 3.671_847_302_652, 1e-11);
    scene.plant.dt = exact / f64::from(steps);
    let mut plant = Plant::new(&scene).expect("a box");
    let start = totals(&plant);
    let mut drift = [0.0_f64; 2];
    for _ in 0..steps {
        step(&mut plant);
        let now = totals(&plant);
        drift[0] = drift[0].max((now.kinetic / start.kinetic - 1.0).abs());
        drift[1] = drift[1].max((now.angular - start.angular).norm() / start.angular.norm());
    }
    [(body_rate(&plant) - Vector3::new(1.0, 2.0, 3.0)).norm(), drift[0], drift[1]]
}

#[test]
fn a_tumbling_box_repeats_its_angular_velocity_after_its_period() {
    let methods = [
        ("ExplicitEuler", 1),
        ("SemiImplicitEuler", 1),
        ("MoreauJean", 2),
        ("MidpointMoreau", 2),
        ("ImplicitMidpoint", 2),
        ("Rk4", 4),
        ("Rk4Impact", 4),
    ];
    for (method, order) in methods {
        let [coarse, fine] = [200, 400].map(|steps| tumble(method, steps));
        println!("{method}: {coarse:?}, {fine:?} with half the step");
        for (coarse, fine) in coarse.iter().zip(fine) {
            assert!(fine < 1e-12 || *coarse > 0.8 * fine * 2f64.powi(order), "{method} is not of order {order}");
        }
    }
    for (method, steps, most) in [("StepDoubling", 400, 1e-5), ("EventDriven", 100, 1e-9), ("Rk4", 4000, 1e-9)] {
        let errors = tumble(method, steps);
        println!("{method}: {errors:?}");
        assert!(errors.iter().all(|error| *error < most), "{method}: {errors:?}");
    }
}

/// In 5 s with steps of 10 ms, explicit Euler loses 1/14 of the energy (and gains it if the angular velocity is integrated in the body frame).
/// The implicit midpoint rule keeps the energy within 1e-5.
#[test]
fn explicit_euler_does_not_conserve_the_energy_of_a_box() {
    let gain = |method: &str| {
        let mut plant = plant("spinning-box", &[&format!("plant.method={method}"), "plant.dt=0.01", "rate=100"]);
        let start = totals(&plant).kinetic;
        run(&mut plant, 5.0);
        totals(&plant).kinetic / start - 1.0
    };
    let [explicit, implicit] = ["ExplicitEuler", "ImplicitMidpoint"].map(gain);
    println!("energy gained: {explicit:e} and {implicit:e}");
    assert!((0.05..0.1).contains(&explicit.abs()) && implicit.abs() < 1e-5);
}

/// Orientation of a cube with the given roll, after a rotation about its own y axis.
fn turned(roll: f64, angle: f64) -> Rotation3<f64> {
    Rotation3::from_axis_angle(&Vector3::x_axis(), roll) * Rotation3::from_axis_angle(&Vector3::y_axis(), angle)
}

/// Error of the orientation after 3 s, in which the pitch passes 90° at a distance of `roll` from the singularity [rad].
fn gimbal(base: Base, roll: f64, settings: &[&str]) -> Result<f64, plant::PlantError> {
    let mut scene = scene("gimbal", settings);
    scene.plant.base = base;
    scene.initial.orientation_deg = [roll.to_degrees(), 0.0, 0.0];
    scene.initial.angular_velocity = [0.0, roll.cos(), roll.sin()];
    let mut plant = Plant::new(&scene)?;
    while plant.time_ns() < 3_000_000_000 {
        plant.step()?;
    }
    let rotation = pose(&plant).links[plant.model().base_link].rotation;
    Ok((rotation - turned(roll, 3.0).matrix()).norm())
}

#[test]
fn a_quaternion_base_passes_the_pole_without_loss_of_accuracy() {
    for roll in [0.1, 0.01, 0.001, 0.0] {
        let error = gimbal(Base::Quaternion, roll, &[]).expect("a turn");
        println!("roll {roll}: {error:e}");
        assert!(error < 1e-12);
    }
}

/// At the pole of the virtual joints H is singular. That is an error, not a NaN.
#[test]
fn virtual_joints_lose_digits_near_the_pole_and_report_it_at_the_pole() {
    let errors = [0.1, 0.01, 0.001].map(|roll| gimbal(Base::Virtual, roll, &["plant.method=Rk4"]).expect("a turn"));
    println!("{errors:?}");
    assert!(errors[0] < 1e-9 && errors[0] < errors[1] && errors[1] < errors[2]);
    assert!((1e-4..1.0).contains(&errors[2]));
    for roll in [1e-3, 1e-6, 1e-9, 0.0] {
        match gimbal(Base::Virtual, roll, &[]) {
            Ok(error) => assert!(error.is_finite()),
            Err(error) => println!("roll {roll}: {error}"),
        }
    }
    let at_pole = scene("gimbal", &["initial.orientation_deg=[0.0, 90.0, 0.0]"]);
    let error = Plant::new(&at_pole).err().expect("a singular pose").to_string();
    assert!(error.contains("±90°"), "{error}");
}

/// The centre of mass of a tumbling robot follows the parabola of a falling point.
#[test]
fn a_robot_in_flight_conserves_its_momenta() {
    let euler = ["plant.method=SemiImplicitEuler", "rate=1000"];
    let settings = ["plant.gravity=9.81", "initial.position=[0.0, 0.0, 40.0]", "initial.velocity=[1.0, -0.5, 2.0]"];
    let drift = |h: f64| {
        let mut plant = plant("free", &[&euler[..], &settings, &[&format!("plant.dt={h}")]].concat());
        let start = totals(&plant);
        run(&mut plant, 2.0);
        let now = totals(&plant);
        let parabola = start.com + start.com_velocity * 2.0 - Vector3::z() * (0.5 * 9.81 * 4.0);
        let energy = (now.kinetic + now.potential) - (start.kinetic + start.potential);
        [(now.com - parabola).norm(), (now.angular - start.angular).norm() / start.angular.norm(), energy.abs()]
    };
    let (coarse, fine) = (drift(1e-3), drift(2.5e-4));
    println!("position, angular momentum, energy: {coarse:?}, {fine:?} with a quarter of the step");
    for (coarse, fine) in coarse.iter().zip(fine) {
        assert!(fine < 0.3 * coarse);
    }
}
