//! Cases of contact from bug reports about other engines, with their correct values.

use crate::support::{after, energy, gap, run_steps, scene_of, totals};
use biped_plant::Plant;
use messages::scene::{Base, Method};
use messages::wire::Torques;

const CUBE: &str = "[[bodies]]\nname = \"cube\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
    contacts = [[0.05, 0.05, -0.05], [0.05, -0.05, -0.05], [-0.05, 0.05, -0.05], [-0.05, -0.05, -0.05]]\n";

/// Cf. MuJoCo #752: it leaves the ground gently and rests on it.
#[test]
fn a_body_that_starts_inside_the_ground_leaves_it_slowly_and_rests() {
    let text = format!("[plant]\nfriction = 0.5\n[initial]\nposition = [0.0, 0.0, 0.04]\n{CUBE}");
    for method in Method::ALL {
        let mut scene = scene_of(1e-3, &text);
        scene.plant.method = method;
        let mut plant = Plant::new(&scene).expect("a cube");
        assert!((plant.truth().penetration - 0.01).abs() < 1e-12);
        let mut fastest = 0.0_f64;
        for _ in 0..500 {
            run_steps(&mut plant, 1);
            fastest = fastest.max(plant.state().xdot[2]);
        }
        println!("{method:?}: {:.1e} m inside at .5 s, rose at {fastest:.3} m/s at most", -gap(&plant));
        let events = [Method::Rk4Impact, Method::EventDriven].contains(&method);
        let rest = if method == Method::MidpointContact { 1e-6 } else { 1.1e-4 }; // ten times g h²
        assert!(gap(&plant) > -rest && gap(&plant) < 1e-3 && fastest < 0.11, "{method:?}, {events}");
    }
}

/// Cf. godot-jolt #796: contacts that gain more than .5 m/s within a step are detected.
#[test]
fn under_a_hundredfold_gravity_a_cube_lands_and_stays() {
    let plant = after(&scene_of(0.01, &format!("[plant]\ngravity = 981.0\n[initial]\nclearance = 0.05\n{CUBE}")), 1.0);
    assert!(gap(&plant).abs() < 1e-9 && plant.state().xdot.iter().all(|v| v.abs() < 1e-6), "{:e}", gap(&plant));
}

/// A pendulum passes above the ground by less than its path is curved within a step. A prediction of its height along a straight line would stop
/// it: .6 s after it was let go at 1 rad it is at −.806 rad, but was at −.32 to −.62.
#[test]
fn a_grazing_pendulum_passes() {
    let text = "[plant]\nbase = \"fixed\"\n[initial]\nposition = [0.0, 0.0, 0.300001]\njoints = [1.0]\n[[bodies]]\nname = \"b\"\n\
        mass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"l\"\nmass = 0.1\nsize = [0.05, 0.05, 0.3]\ncom = [0.0, 0.0, -0.15]\n\
        joint = { parent = \"b\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\ncontacts = [[0.0, 0.0, -0.3]]\n\
        inertia = [0.001, 0.001, 0.001]\n";
    for method in Method::ALL {
        for (dt, clearance) in [(1e-3, 1e-6), (2e-3, 1e-6), (5e-3, 1e-6), (1e-3, 1e-9), (2e-3, 3e-5), (5e-3, 1e-4)] {
            let mut scene = scene_of(dt, text);
            scene.plant.method = method;
            scene.initial.position[2] = 0.3 + clearance;
            let plant = after(&scene, 0.6);
            let q = plant.state().x[0];
            let error = match method {
                Method::ExplicitEuler => 13.0 * dt,
                Method::SemiImplicitEuler => 2.0 * dt,
                _ => 10.0 * dt * dt,
            };
            println!("{method:?}, dt {dt}, clearance {clearance:e}: {q:.5} rad");
            assert!((q + 0.80569).abs() < error, "{method:?}, dt {dt}, clearance {clearance:e}: {q}");
            assert_eq!(plant.counts().events, 0, "{method:?}, dt {dt}, clearance {clearance:e}");
        }
    }
}

/// x and θ at 2 s, for any position of the body's frame, by every method, on every base that lets it roll.
#[test]
fn a_loaded_ball_rolls_the_same_wherever_its_frame_is() {
    let tilt = -68.754_935_415_698_78_f64;
    let (sin, cos) = tilt.to_radians().sin_cos();
    let roll = |dt: f64, method: Method, base: Base, [x, z]: [f64; 2]| {
        let text = format!(
            "[plant]\nfriction = 2.0\n[initial]\nclearance = 0.0\nposition = [{:?}, 0.0, 0.0]\norientation_deg = [0.0, {tilt}, 0.0]\n\
             [[bodies]]\nname = \"ball\"\nmass = 1.0\nsize = [0.2, 0.2, 0.2]\ncom = [{:?}, 0.0, {:?}]\ninertia = [0.002, 0.002, 0.002]\n\
             spheres = [{{ at = [{:?}, 0.0, {:?}], radius = 0.1 }}]\n",
            cos * x + sin * z,
            -x,
            -0.04 - z,
            -x,
            -z,
        );
        let mut scene = scene_of(dt, &text);
        (scene.plant.base, scene.plant.method) = (base, method);
        let plant = after(&scene, 2.0);
        let truth = plant.truth();
        [
            totals(&plant).com.x,
            2.0 * truth.base_orientation[2].asin(),
            plant.state().xdot[if base == Base::Planar { 2 } else { 4 }],
        ]
    };
    let [angle, rate] = [-1.198_763_45, 0.290_818_29];
    for method in Method::ALL {
        let mut first = None;
        for base in [Base::Planar, Base::Quaternion, Base::Virtual] {
            for frame in [[0.0, 0.0], [0.0, -0.04], [0.3, 0.1]] {
                let end = roll(1e-3, method, base, frame);
                let [x, turn, _] = *first.get_or_insert(end);
                println!("{method:?} {base:?} {frame:?}: {end:?}");
                assert!(
                    (end[0] - x).abs() < 1e-9 && (end[1] - turn).abs() < 1e-9,
                    "{method:?} {base:?} {frame:?}: {end:?}"
                );
            }
        }
    }
    let errors =
        [2e-3, 1e-3, 5e-4].map(|dt| (roll(dt, Method::MidpointContact, Base::Planar, [0.0, 0.0])[1] - angle).abs());
    println!("errors of the angle {errors:?}");
    let end = roll(1e-3, Method::EventDriven, Base::Quaternion, [0.0, 0.0]);
    println!("EventDriven: {end:?}");
    assert!((end[1] - angle).abs() < 1e-8 && (end[2] - rate).abs() < 1e-7, "{end:?}");
    assert!(errors[1] < 2e-5 && errors[2] < errors[0] / 8.0, "{errors:?}");
}

/// Every throw of the reference method's claim, with the default method: the energy only falls.
#[test]
fn thrown_bodies_never_gain_energy() {
    for seed in 0..60 {
        let mut scene = crate::throws::thrown(&mut fastrand::Rng::with_seed(seed));
        (scene.plant.method, scene.plant.dt, scene.rate) = (Method::MidpointContact, 1e-3, 1e3);
        let mut plant = Plant::new(&scene).expect("a body");
        let (mut last, first) = (energy(&plant), energy(&plant));
        for step in 0..1000 {
            plant.advance(&Torques::default()).unwrap_or_else(|error| panic!("seed {seed}: {error}"));
            let now = energy(&plant);
            // second order: the energy error of a step is proportional to h²
            assert!(now < last + 2e-4 * first.abs(), "seed {seed}, step {step}: {last} becomes {now} J of {first}");
            last = last.min(now);
        }
    }
}
