//! Springs of joints that swing make no energy, and dampers stop their joints.

use crate::support::{body, energy, plant, run_steps, totals};
use biped_plant::Plant;
use messages::load::parse;
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Method, Scene};

/// Length of a run [s], and of a step [s].
const DURATION: f64 = 2.0;
const DT: f64 = 1e-3;

/// A box with up to four arms on springs of up to 100 N·m/rad or 10 kN/m, deflected by up to .2 rad or .02 m. Arms may carry arms.
fn arms(random: &mut fastrand::Rng, base: Base) -> Scene {
    let mut scene = body([0.2, 0.2, 0.4], vec![]);
    scene.plant.base = base;
    scene.plant.drive_inertia = 0.0;
    let count = random.usize(1..5);
    for i in 0..count {
        let parent = scene.bodies[random.usize(0..scene.bodies.len())].name.clone();
        let slides = i > 0 && random.f64() < 0.25;
        let joint = Joint {
            parent,
            kind: if slides { JointKind::Prismatic } else { JointKind::Revolute },
            axis: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.6, 0.8]][random.usize(0..3)],
            at: [0.05, 0.4 * (random.f64() - 0.5), 0.2],
            stiffness: if slides { 1e4 } else { 100.0 } * random.f64(),
            damping: 0.0,
            rest: 0.0,
        };
        let arm = Body {
            name: format!("arm {i}"),
            mass: 0.05 + 0.3 * random.f64(),
            size: [0.1, 0.1, 0.2],
            com: [0.0, 0.0, 0.1],
            joint: Some(joint),
            ..Body::default()
        };
        scene.bodies.push(arm);
        scene.initial.joints.push(if slides { 0.02 } else { 0.2 } * (2.0 * random.f64() - 1.0));
    }
    scene
}

/// Energy with that of the springs of joints [J].
fn whole_energy(plant: &Plant) -> f64 {
    let (model, state) = (plant.model(), plant.state());
    let offset = state.x.len() - state.xdot.len();
    let springs = model.springs.iter().map(|spring| {
        let deflection = state.x[spring.dof + offset] - spring.rest;
        0.5 * spring.stiffness * deflection * deflection
    });
    energy(plant) + springs.sum::<f64>()
}

/// The greatest gain and loss of energy in the run, relative to the greatest kinetic energy.
fn change_of_energy(mut plant: Plant) -> [f64; 2] {
    let start = whole_energy(&plant);
    let (mut gain, mut loss, mut kinetic) = (0.0_f64, 0.0_f64, 0.0_f64);
    for _ in 0..(DURATION / DT) as usize {
        run_steps(&mut plant, 1);
        let change = whole_energy(&plant) - start;
        (gain, loss) = (gain.max(change), loss.max(-change));
        kinetic = kinetic.max(totals(&plant).kinetic);
    }
    [gain / kinetic, loss / kinetic]
}

/// Taken at x + ½hẋ₋ alone, H lets such springs gain up to several times their energy.
#[test]
fn springs_that_swing_in_flight_keep_their_energy_by_every_midpoint_rule() {
    for method in [Method::MidpointContact, Method::MidpointMoreau, Method::ImplicitMidpoint] {
        let mut random = fastrand::Rng::with_seed(41);
        let mut worst = 0.0_f64;
        for _ in 0..10 {
            for base in [Base::Quaternion, Base::Virtual, Base::Planar, Base::Fixed] {
                let [gain, loss] = change_of_energy(plant(arms(&mut random, base), method, DT));
                worst = worst.max(gain).max(loss);
            }
        }
        println!("{method:?}: the energy changes by {worst:.1e} of the motion's");
        assert!(worst < 0.005, "{method:?}: {worst:e}");
    }
}

#[test]
fn springs_that_swing_on_a_standing_box_make_no_energy() {
    let mut random = fastrand::Rng::with_seed(42);
    let mut worst = 0.0_f64;
    for _ in 0..20 {
        let mut scene = arms(&mut random, Base::Quaternion);
        scene.plant.gravity = 9.81;
        scene.bodies[0].mass = 5.0;
        scene.bodies[0].contacts =
            [[0.5, 0.5], [0.5, -0.5], [-0.5, 0.5], [-0.5, -0.5]].map(|[x, y]| [x, y, -0.2]).to_vec();
        scene.initial.position[2] = 0.2;
        worst = worst.max(change_of_energy(plant(scene, Method::MidpointContact, DT))[0]);
    }
    println!("gains at most {worst:.1e} of the motion's energy");
    assert!(worst < 0.005, "{worst:e}");
}

/// The joint's damper stops a light limb within .2 µs. A stage of `EventDriven` over the whole step would leave the range of numbers.
#[test]
fn a_damper_much_faster_than_the_step_stops_a_limb_of_a_free_body() {
    let text = "[plant]\ngravity = 0.0\n[initial]\njoint_rates = [1.3]\n[[bodies]]\nname = \"a\"\nmass = 1.0\nsize = [0.1, 0.3, 0.3]\n\
        [[bodies]]\nname = \"b\"\nmass = 0.02\nsize = [0.4, 0.3, 0.4]\ncom = [-0.05, -0.05, 0.0]\n\
        joint = { parent = \"a\", axis = [0.0, 0.0, 1.0], at = [0.1, 0.0, 0.2], damping = 100.0 }\n";
    for method in [Method::MidpointContact, Method::ImplicitMidpoint, Method::EventDriven] {
        let mut plant = plant(parse(text, "a test").expect("a scene"), method, DT);
        run_steps(&mut plant, 50);
        println!("{method:?}: {:.1e} rad/s, {} rejected", plant.state().xdot[6], plant.counts().rejected);
        assert!(plant.state().xdot[6].abs() < 1e-3, "{method:?}: {:e}", plant.state().xdot[6]);
    }
}

/// A box lands flat and stops. A limb of 1 kg on it goes on against a damper c: q = −(g/c)s − (v − g/c)/c (1 − e^(−cs)) at a time s after the landing at
/// v. If the joint moved by the mean of its velocities as after other steps, it would go half a step too far: 5e-4 m at 1 ms.
#[test]
fn a_damper_stops_a_limb_of_a_body_that_lands_as_far_as_it_should() {
    let methods = [Method::MidpointContact, Method::MidpointMoreau, Method::ImplicitMidpoint];
    let (g, height): (f64, f64) = (9.81, 0.05);
    for damping in [30.0, 300.0, 1e3, 1e4, 1e6, 1e12] {
        for h in [4e-3_f64, 2e-3, 1e-3, 5e-4] {
            let steps = (0.3 / h).round();
            let (landing, after) = ((2.0 * height * g).sqrt(), steps * h - (2.0 * height / g).sqrt());
            let [steady, stops] = [g / damping, 1.0 - (-damping * after).exp()];
            let expected = -steady * after - (landing - steady) / damping * stops;
            for method in methods {
                let mut plant = plant(box_with_damped_limb(damping, height), method, h);
                run_steps(&mut plant, steps as usize);
                let error = plant.state().x[7] - expected;
                println!("{method:?}, c = {damping:e}, h = {h}: {error:.1e} of {expected:.1e} m");
                assert!(error.abs() < 2.0 * h * h + 2e-9, "{method:?}, c = {damping:e}, h = {h}: {error:e} m");
            }
        }
    }
}

/// Likewise for a limb that moves at the beginning of a run: it goes v/c.
#[test]
fn a_damper_stops_a_limb_that_moves_at_the_beginning_as_far_as_it_should() {
    for method in [Method::MidpointContact, Method::MidpointMoreau, Method::ImplicitMidpoint] {
        for damping in [1e3, 1e4, 1e12] {
            let mut scene = box_with_damped_limb(damping, 0.0);
            (scene.plant.gravity, scene.initial.joint_rates) = (1e-3, vec![-1.0]);
            let mut plant = plant(scene, method, DT);
            run_steps(&mut plant, 50);
            let error = plant.state().x[7] + 1.0 / damping;
            assert!(error.abs() < 2e-6, "{method:?}, c = {damping:e}: {error:e} m");
        }
    }
}

/// A box of 1 kg at this height [m], and a limb of 1 kg that a damper [N·s/m] holds above it.
fn box_with_damped_limb(damping: f64, height: f64) -> Scene {
    let text = format!(
        "[initial]\nclearance = {height}\n[[bodies]]\nname = \"box\"\nmass = 1.0\nsize = [0.2, 0.2, 0.1]\n\
         contacts = [[0.1, 0.1, -0.05], [-0.1, 0.1, -0.05], [0.1, -0.1, -0.05], [-0.1, -0.1, -0.05]]\n\
         [[bodies]]\nname = \"limb\"\nmass = 1.0\nsize = [0.05, 0.05, 0.05]\n\
         joint = {{ parent = \"box\", kind = \"prismatic\", axis = [0.0, 0.0, 1.0], at = [0.0, 0.0, 0.3], damping = {damping:e} }}\n"
    );
    parse(&text, "a test").expect("a scene")
}
