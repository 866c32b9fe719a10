//! Impacts with a closed-form solution: scenes 5, 6, 7 and 10. With almost no gravity, one step shows the impact law alone.

use crate::support::{G, assert_near, load, plant, scene, spin, step, threshold, totals};
use messages::scene::{Law, Scene};
use nalgebra::Vector3;
use plant::Plant;
use std::f64::consts::PI;

/// Laws that are exactly Coulomb's in the plane.
const COULOMB: [Law; 2] = [Law::Complementarity, Law::Aligned];

/// The body of a scene, upright on the ground and rotating at `spin` about the point (x, 0).
fn turning(name: &str, law: Law, x: f64, height: f64, spin: f64) -> Scene {
    let mut scene = scene(name, &["plant.gravity=1e-9", "initial.clearance=0.0", &format!("plant.law={law}")]);
    scene.initial.orientation_deg = [0.0; 3];
    scene.initial.angular_velocity = [0.0, spin, 0.0];
    scene.initial.velocity = [spin * height, 0.0, spin * x];
    scene
}

/// Velocity of the base after one step: forward, up, and about the y axis.
fn after(scene: &Scene) -> [f64; 3] {
    let mut plant = Plant::new(scene).expect("a body");
    plant.step().expect("a step");
    plant.state().xdot[..].try_into().expect("a planar base")
}

#[test]
fn an_impact_of_a_rocking_block_keeps_housners_fraction_of_its_angular_velocity() {
    let tilt = 0.25_f64.atan();
    let ratio = 1.0 - 1.5 * tilt.sin().powi(2);
    assert_near("ratio", ratio, 0.911_764_705_882, 1e-12);
    for law in COULOMB {
        let scene = turning("rocking-block", law, 0.1, 0.4, -1.0);
        let [forward, up, spin] = after(&scene);
        assert_near("spin", spin, -ratio, 1e-10);
        assert_near("forward", forward, 0.4 * spin, 1e-10);
        assert_near("up", up, -0.1 * spin, 1e-10);
        let mut plant = Plant::new(&scene).expect("a block");
        let before = totals(&plant).kinetic;
        plant.step().expect("a step");
        assert_near("energy ratio", totals(&plant).kinetic / before, 0.831_314_878_893, 1e-10);
        let least = threshold(0.0, 0.5, |mu| {
            let mut scene = scene.clone();
            scene.plant.friction = mu;
            (after(&scene)[2] + ratio).abs() < 1e-10
        });
        assert_near("least friction", least, 2.4 / 13.0, 1e-9);
    }
}

/// If a block is wider than √2 times its height, both corners stay on the ground.
#[test]
fn a_squat_block_stops_at_its_first_impact() {
    for law in COULOMB {
        for speed in after(&turning("squat-block", law, 0.15, 0.1, -1.0)) {
            assert_near("speed", speed, 0.0, 1e-10);
        }
        let widest = threshold(0.11, 0.2, |half| {
            let mut scene = turning("squat-block", law, half, 0.1, -1.0);
            scene.bodies[0].size[0] = 2.0 * half;
            scene.bodies[0].contacts = vec![[half, 0.0, -0.1], [-half, 0.0, -0.1]];
            after(&scene)[2].abs() < 1e-12
        });
        assert_near("half the width", widest, 0.1 * 2f64.sqrt(), 1e-9);
    }
}

/// A rimless wheel keeps the fraction (ρ² + cos 2a)/(1 + ρ²) of its angular velocity; a is half the angle between spokes.
#[test]
fn an_impact_of_a_rimless_wheel_keeps_the_predicted_fraction_of_its_angular_velocity() {
    let half = PI / 8.0;
    for law in COULOMB {
        for gyration in [1e-6, 0.1, 1.0_f64] {
            let mut scene = turning("rimless-wheel", law, half.sin(), half.cos(), 1.0);
            // about the rear tip, which is at -x
            scene.initial.velocity = [half.cos(), 0.0, -half.sin()];
            scene.bodies[0].inertia = Some([gyration; 3]);
            let ratio = (gyration + (2.0 * half).cos()) / (1.0 + gyration);
            assert_near("spin", after(&scene)[2], ratio, 1e-10);
            if gyration < 1e-3 {
                let least = threshold(0.0, 1.0, |mu| {
                    scene.plant.friction = mu;
                    (after(&scene)[2] - ratio).abs() < 1e-9
                });
                assert_near("least friction", least, half.tan(), 1e-6);
            }
        }
    }
}

/// Painlevé's rod: its leading tip stops at once if μ > (t² + 4)/3t, t = tan θ, at any step size.
#[test]
fn a_rod_jams_at_painleves_angle() {
    let (c, s) = (0.2_f64.sqrt(), 0.8_f64.sqrt());
    let (normal, both, tangent) = (1.0 + 3.0 * c * c, 3.0 * c * s, 1.0 + 3.0 * s * s);
    let determinant = normal * tangent - both * both;
    for law in COULOMB {
        for h in [1e-3, 1e-5, 1e-7, 1e-9] {
            let rod = |mu: f64| {
                let settings = [format!("plant.dt={h}"), format!("rate={}", 1.0 / h), format!("plant.friction={mu}")];
                scene(
                    "painleve-rod",
                    &[&settings.each_ref().map(String::as_str)[..], &[&format!("plant.law={law}")]].concat(),
                )
            };
            let mut plant = Plant::new(&rod(1.4)).expect("a rod");
            plant.advance(&messages::wire::Torques::default()).expect("a step");
            let force: Vector3<f64> = load(&plant, 0) * h;
            // the impulse stops both components of the tip's velocity, (-g h, 1)
            let fall = 9.81 * h;
            assert_near("f_N", force.z, (both + tangent * fall) / determinant, 1e-10);
            assert_near("f_F", force.x, -(normal + both * fall) / determinant, 1e-10);
            assert_near("f_N in the limit", force.z, 0.3, 10.0 * fall);
            assert_near("f_F in the limit", force.x, -0.4, 10.0 * fall);
            assert_near("energy ratio", totals(&plant).kinetic / 0.5, 0.6, 10.0 * fall);
            // below the limit the rod continues to slide
            assert_near("v", after(&rod(1.3))[0], 1.0, 100.0 * fall);
        }
    }
}

/// No force exists that would let the tip slide on. Methods with forces take an impulse there, tell it as a fallback, and go on.
#[test]
fn a_rod_that_jams_stops_by_an_impulse_under_methods_with_forces() {
    for (method, law) in
        ["EventDriven", "Rk4Impact"].into_iter().flat_map(|method| [Law::Cone, Law::Aligned].map(|law| (method, law)))
    {
        for h in [1e-3, 1e-5] {
            let settings = [
                format!("plant.method={method}"),
                format!("plant.law={law}"),
                format!("plant.dt={h}"),
                format!("rate={}", 1.0 / h),
            ];
            let mut plant =
                Plant::new(&scene("painleve-rod", &settings.each_ref().map(String::as_str))).expect("a rod");
            plant.advance(&messages::wire::Torques::default()).expect("a step");
            let stopped = totals(&plant).kinetic;
            assert_near("energy ratio", stopped / 0.5, 0.6, 10.0 * 9.81 * h);
            assert_eq!(plant.truth().fallbacks, 1, "{settings:?}");
            (1..20).for_each(|_| _ = plant.advance(&messages::wire::Torques::default()).expect("a step"));
            assert_eq!(plant.truth().fallbacks, 1, "{settings:?}: after the impulse the tip does not slide");
            assert_near("energy", totals(&plant).kinetic, stopped, 20.0 * 9.81 * h);
        }
    }
}

#[test]
fn the_least_friction_that_jams_a_rod_is_four_thirds() {
    for law in COULOMB {
        for tangent in [1.0, 1.5, 2.0, 2.5, 4.0_f64] {
            let jams = |mu: f64| {
                let mut scene = scene("painleve-rod", &["plant.dt=1e-10", "rate=1e10", &format!("plant.law={law}")]);
                scene.plant.friction = mu;
                let angle = tangent.atan();
                scene.bodies[0].contacts = vec![[angle.cos(), 0.0, -angle.sin()]];
                after(&scene)[0] < 0.9
            };
            let exact = (tangent * tangent + 4.0) / (3.0 * tangent);
            assert_near("least friction", threshold(1.0, 2.5, jams), exact, 1e-7);
            assert!(exact >= 4.0 / 3.0 && (tangent != 2.0 || exact == 4.0 / 3.0));
        }
    }
}

/// Under the printed QP the rod stops at any friction, because its slip throws the tip upward.
#[test]
fn the_printed_qp_ejects_the_rod_at_any_friction() {
    for mu in [0.2, 0.5, 1.0, 1.3] {
        let settings = [format!("plant.friction={mu}"), "plant.dt=1e-9".into(), "rate=1e9".into()];
        let scene =
            scene("painleve-rod", &[&settings.each_ref().map(String::as_str)[..], &["plant.law=EnergyQp"]].concat());
        let [forward, up, _] = after(&scene);
        println!("mu {mu}: {forward} m/s, up {up} m/s");
        assert!(forward < 0.97 && up > 0.01);
    }
}

/// The time from half the critical tilt to the impact, ∫ dθ/ω with ω² = 2 p² (cos(α - θ₀) - cos(α - θ)), p² = 3 g/4 R. The
/// substitution θ = θ₀ (1 - u²) removes the singularity at the start.
fn quarter_period() -> f64 {
    let (tipping, radius) = (0.25_f64.atan(), 0.1_f64.hypot(0.4));
    let (start, pull) = (0.5 * tipping, 3.0 * 9.81 / (4.0 * radius));
    let rate = |u: f64| {
        let angle = start * (1.0 - u * u);
        // cos(α - θ₀) - cos(α - θ) without cancellation
        let fall = 2.0 * ((2.0 * tipping - start - angle) / 2.0).sin() * ((start - angle) / 2.0).sin();
        if u == 0.0 { 0.0 } else { 2.0 * start * u / (2.0 * pull * fall).sqrt() }
    };
    // Richardson extrapolation of the midpoint rule, because the integrand is even and smooth
    let sum = |n: u32| (0..n).map(|k| rate((f64::from(k) + 0.5) / f64::from(n))).sum::<f64>() / f64::from(n);
    let [a, b, c] = [1000, 2000, 4000].map(sum);
    let [d, e] = [(4.0 * b - a) / 3.0, (4.0 * c - b) / 3.0];
    (16.0 * e - d) / 15.0
}

/// Just before and just after the impact, at a relative distance of 1e-9: the angular velocity follows from the energy, then from Housner.
#[test]
fn a_rocking_block_strikes_after_its_quarter_period() {
    let exact = quarter_period();
    assert_near("quarter period", exact, 0.312_308_575, 1e-9);
    let (tipping, radius) = (0.25_f64.atan(), 0.1_f64.hypot(0.4));
    let before = -(1.5 * 9.81 / radius * ((0.5 * tipping).cos() - tipping.cos())).sqrt();
    let ratio = 1.0 - 1.5 * tipping.sin().powi(2);
    for (part, spin) in [(1.0 - 1e-9, before), (1.0 + 1e-9, ratio * before)] {
        let mut scene = scene("rocking-block", &["plant.method=EventDriven"]);
        scene.plant.dt = exact * part / 100.0;
        let mut plant = Plant::new(&scene).expect("a block");
        for _ in 0..100 {
            plant.step().expect("a step");
        }
        assert_near("spin", plant.state().xdot[2], spin, 1e-8);
    }
}

/// After a few sweeps of projected Gauss-Seidel, the corner that should lift still carries load.
#[test]
fn projected_gauss_seidel_keeps_both_corners_of_a_rocking_block_loaded() {
    let ratio = 1.0 - 1.5 * 0.25_f64.atan().sin().powi(2);
    let error = |sweeps: u16| -after(&turning("rocking-block", Law::Sweep(sweeps), 0.1, 0.4, -1.0))[2] - ratio;
    let errors = [1, 4, 50].map(error);
    println!("spin off by {errors:?} after 1, 4 and 50 sweeps");
    assert!(errors[0].abs() > 1e-3 && errors[2].abs() < errors[0].abs());
}

/// A thrown box tumbles over its corners and comes to rest on a face. No step gains energy.
#[test]
fn a_thrown_box_comes_to_rest_on_a_face() {
    for settings in [&[][..], &["plant.method=SemiImplicitEuler"]] {
        let mut plant = plant("thrown-box", settings);
        let energy = |plant: &Plant| totals(plant).kinetic + totals(plant).mass * G * totals(plant).com.z;
        let (first, mut before, mut gained) = (energy(&plant), energy(&plant), 0.0);
        while plant.time_ns() < 1_500_000_000 {
            step(&mut plant);
            gained += (energy(&plant) - before).max(0.0);
            before = energy(&plant);
        }
        let (speed, height) = (totals(&plant).linear.norm() + spin(&plant).norm(), totals(&plant).com.z);
        println!("{settings:?}: {height} m up at {speed:.1e} m/s, gained {gained:.1e} of {first} J");
        assert!([0.025, 0.05, 0.1].iter().any(|half| (height - half).abs() < 1e-6) && speed < 1e-6, "{settings:?}");
        assert!(gained < 1e-9 * first, "{settings:?}: {gained} J");
    }
}
