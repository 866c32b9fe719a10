//! Landings by `MidpointContact`, and the steps around them.

use crate::support::{body, box_corners, distance, gap, plant, run_steps, totals};
use biped_plant::Plant;
use messages::load::parse;
use messages::robot::{Body, Joint, JointKind};
use messages::scene::{Base, Method, Scene};
use nalgebra::Vector3;

const G: f64 = 9.81;
const SEED: u64 = 40;

/// A leg on a point, with an arm that swings, a `time` before it lands.
fn falling_leg(time: f64) -> Scene {
    let fall = 1.0;
    let mut scene = body([0.1, 0.1, 0.4], vec![[0.0, 0.0, -0.2]]);
    let joint = Joint {
        parent: "body".into(),
        kind: JointKind::Revolute,
        axis: [0.0, 1.0, 0.0],
        at: [0.0, 0.0, 0.2],
        stiffness: 0.0,
        damping: 0.0,
        rest: 0.0,
    };
    let (size, com, joint) = ([0.1, 0.1, 0.4], [0.1, 0.0, 0.2], Some(joint));
    scene.bodies.push(Body { name: "arm".into(), mass: 1.0, size, com, joint, ..Body::default() });
    (scene.plant.base, scene.plant.gravity, scene.plant.friction) = (Base::Planar, G, 100.0);
    scene.initial.clearance = Some(fall * time + 0.5 * G * time * time);
    (scene.initial.velocity, scene.initial.joint_rates) = ([0.0, 0.0, -fall], vec![8.0]);
    scene
}

/// After an impact the acceleration is that of another motion, so it is not taken from the part of the step before.
#[test]
fn a_step_with_an_impact_has_an_error_of_third_order() {
    let errors = [16e-3, 8e-3, 4e-3].map(|h| {
        let end = |method: Method, steps: usize| -> Plant {
            let mut plant = plant(falling_leg(1.5 * h), method, 2.0 * h / steps as f64);
            run_steps(&mut plant, steps);
            plant
        };
        let step = end(Method::MidpointContact, 2);
        assert!(gap(&step).abs() < 1e-5, "h = {h}: {:e} m above the ground", gap(&step));
        distance(&step, &end(Method::EventDriven, 2))
    });
    println!("errors of velocity {errors:?}");
    assert!(errors.windows(2).all(|pair| pair[0] > 6.0 * pair[1]), "{errors:?}");
}

/// The rest of a step after an impact tells the next step the acceleration, which then needs no second contact problem. A very short rest does not,
/// and after an impact that a damper feels none does.
#[test]
fn a_step_after_a_landing_is_solved_once_if_the_rest_of_the_landing_tells_its_acceleration() {
    let h = 1e-3;
    for (rest, damping, problems) in [(0.9, 0.0, 1), (0.3, 0.0, 1), (0.03, 0.0, 2), (0.9, 0.1, 2)] {
        let mut scene = falling_leg((2.0 - rest) * h);
        if let Some(joint) = &mut scene.bodies[1].joint {
            joint.damping = damping;
        }
        let mut plant = plant(scene, Method::MidpointContact, h);
        run_steps(&mut plant, 2);
        assert_eq!(plant.counts().events, 1, "a rest of {rest}: it must land in the second step");
        let solved = plant.counts().contacts;
        run_steps(&mut plant, 1);
        assert_eq!(plant.counts().contacts - solved, problems, "a rest of {rest}, damping {damping}");
    }
}

/// A point whose speed is below twice the change of its velocity in a step comes to rest without an impact.
#[test]
fn a_soft_landing_is_no_impact_and_a_hard_one_is() {
    let h = 1e-3;
    for (speed, impacts) in [(0.5, 0), (1.5, 0), (2.5, 1), (100.0, 1)] {
        let mut scene = body([0.1; 3], vec![[0.0, 0.0, -0.05]]);
        (scene.plant.base, scene.plant.gravity) = (Base::Planar, G);
        scene.initial.clearance = Some(0.5 * speed * G * h * h);
        scene.initial.velocity = [0.0, 0.0, -speed * G * h];
        let mut plant = plant(scene, Method::MidpointContact, h);
        run_steps(&mut plant, 10);
        println!("{speed} g h: {} events, {:e} m above the ground", plant.counts().events, gap(&plant));
        assert_eq!(plant.counts().events, impacts, "{speed} g h");
        assert!(gap(&plant).abs() < 1e-9, "{speed} g h: {:e}", gap(&plant));
    }
}

/// A sledge at rest, whose arm falls onto the ground and kicks it away. It then slides to rest under friction with its full weight.
#[test]
fn a_blow_that_starts_a_slip_is_followed_by_full_friction() {
    let text = "[plant]\nbase = \"planar\"\nfriction = 0.5\n[initial]\nclearance = 0.0\njoints = [0.8]\njoint_rates = [3.0]\n\
        [[bodies]]\nname = \"sledge\"\nmass = 4.0\nsize = [0.6, 0.3, 0.1]\ncontacts = [[0.3, 0.0, -0.05], [-0.3, 0.0, -0.05]]\n\
        [[bodies]]\nname = \"arm\"\nmass = 0.5\nsize = [0.04, 0.04, 1.0]\ncom = [0.0, 0.0, 0.5]\ncontacts = [[0.0, 0.0, 1.0]]\n\
        joint = { parent = \"sledge\", axis = [0.0, 1.0, 0.0], at = [0.3, 0.0, 0.5] }\n";
    for method in [Method::MidpointContact, Method::StepDoubling, Method::Rk4Impact, Method::EventDriven] {
        let mut plant = plant(parse(text, "a test").expect("a scene"), method, 1e-3);
        let start = plant.state().x[0];
        let mut fastest = 0.0_f64;
        for _ in 0..400 {
            run_steps(&mut plant, 1);
            fastest = fastest.max(plant.state().xdot[0].abs());
        }
        let way = (plant.state().x[0] - start).abs();
        // friction may have acted for a part of a step before the first speed that is seen
        let braked = [fastest, fastest + 0.5 * G * 1e-3].map(|speed| speed.powi(2) / (2.0 * 0.5 * G));
        println!("{method:?}: kicked to {fastest:.4} m/s, it slides {way:.2e} m, by friction {braked:?}");
        assert!(fastest > 0.045 && (braked[0]..=braked[1]).contains(&way), "{method:?}: {way} m instead of {braked:?}");
    }
}

/// A plank stands on four corners, and an arm falls onto the ground beside it. The blow lifts the plank, so the impact is solved from the point that
/// lands. From the modes of the step before, the solver would have to release the corners first: the steps of the blows would take 338 linear systems,
/// those that select the impulses of least norm included.
#[test]
fn a_blow_that_lifts_what_stands_is_solved_from_the_point_that_lands() {
    println!("seed {SEED}");
    let mut random = fastrand::Rng::with_seed(SEED);
    let (mut blows, mut systems) = (0, 0);
    for _ in 0..40 {
        let mut between = |least: f64, most: f64| least + (most - least) * random.f64();
        let text = format!(
            "[plant]\nfriction = {}\n[initial]\nclearance = 0.0\njoints = [0.9]\njoint_rates = [{}]\n[[bodies]]\nname = \"plank\"\nmass = 2.0\n\
             size = [0.6, 0.3, 0.1]\ncontacts = [[0.3, 0.15, -0.05], [0.3, -0.15, -0.05], [-0.3, 0.15, -0.05], [-0.3, -0.15, -0.05]]\n\
             [[bodies]]\nname = \"arm\"\nmass = {}\nsize = [0.04, 0.04, 1.0]\ncom = [0.0, 0.0, 0.5]\ncontacts = [[0.0, 0.0, 1.0]]\n\
             joint = {{ parent = \"plank\", axis = [0.0, 1.0, 0.0], at = [0.3, {}, 0.5] }}\n",
            between(0.5, 1.0),
            between(1.0, 3.0),
            between(0.3, 0.8),
            between(-0.1, 0.1),
        );
        let mut plant = plant(parse(&text, "a test").expect("a scene"), Method::MidpointContact, 1e-3);
        while plant.counts().events == 0 {
            run_steps(&mut plant, 1);
        }
        (blows, systems) = (blows + 1, systems + plant.truth().pivots);
    }
    println!("{systems} linear systems in the slowest problem of each of {blows} blows");
    assert!(systems < 7 * blows, "{systems}");
}

/// A thrown box lands on two corners, turns about the edge between them, which is then parallel to the ground, and falls flat. If one of the two
/// corners of the opposite edge landed first, the box would go another way: 5 mm off after .4 s.
#[test]
fn both_corners_of_an_edge_that_falls_flat_land_at_once() {
    let text = "[initial]\nclearance = 0.1\norientation_deg = [20.0, 30.0, 10.0]\nvelocity = [1.0, 0.3, 0.0]\n\
        angular_velocity = [2.0, -3.0, 1.0]\n[[bodies]]\nname = \"box\"\nmass = 1.0\nsize = [0.2, 0.1, 0.05]\n";
    let mut scene = parse(text, "a test").expect("a scene");
    scene.bodies[0].contacts = box_corners([0.2, 0.1, 0.05]);
    let away = |a: &Plant, b: &Plant| (0..3).map(|i| (a.state().x[i] - b.state().x[i]).abs()).fold(0.0, f64::max);
    for friction in [0.513, 0.548, 0.624, 0.666, 0.711, 0.759, 0.811] {
        scene.plant.friction = friction;
        let end = |method: Method, h: f64| -> Plant {
            let mut plant = plant(scene.clone(), method, h);
            run_steps(&mut plant, (0.4 / h).round() as usize);
            plant
        };
        let right = end(Method::EventDriven, 1e-3);
        for h in [1e-3, 2e-3, 5e-3, 10e-3] {
            let [midpoint, runge_kutta] =
                [Method::MidpointContact, Method::Rk4Impact].map(|method| away(&end(method, h), &right));
            println!("μ = {friction}, h = {h}: {midpoint:.1e}, Rk4Impact {runge_kutta:.1e}");
            assert!(midpoint < 5e-4 && runge_kutta < 5e-4, "μ = {friction}, h = {h}: {midpoint:e}, {runge_kutta:e}");
        }
    }
}

/// A rod of 1 kg turns at ω about its centre, which is so high that its tip enters the ground by `depth` for a time t with ωt/2 = acos(1 − depth/r). In
/// most of these steps it has left the ground again at their end. The impact stops the tip: v = ωx/(1/m + x²/I)/m, with x its distance along the
/// ground. It rises at once, so there is no second impact.
#[test]
fn a_tip_that_enters_and_leaves_the_ground_within_a_step_lands() {
    let (r, inertia) = (0.2, 0.02);
    let ways = [
        (Method::MidpointContact, 2e-3),
        (Method::StepDoubling, 1e-4),
        (Method::Rk4Impact, 1e-4),
        (Method::EventDriven, 1e-7),
    ];
    for (spin, depth, h) in
        [(30.0, 1e-3, 1e-3), (30.0, 1e-3, 5e-3), (30.0, 1e-3, 2e-2), (10.0, 3e-4, 1e-2), (100.0, 2e-3, 1e-3)]
    {
        let entry = f64::acos(1.0 - depth / r);
        let x = r * entry.sin();
        let expected = spin * x / (1.0 + x * x / inertia);
        for phase in 0..7 {
            let before = entry + spin * h * (2.0 + f64::from(phase) / 7.0); // the angle from which it turns until it is upright
            let mut scene = body([0.02, 0.02, 0.4], vec![[0.0, 0.0, -r]]);
            scene.bodies[0].inertia = Some([inertia; 3]);
            (scene.plant.base, scene.plant.friction) = (Base::Planar, 0.0);
            scene.initial.position[2] = r - depth;
            scene.initial.orientation_deg = [0.0, before.to_degrees(), 0.0];
            scene.initial.angular_velocity = [0.0, -spin, 0.0];
            for (method, tolerance) in ways {
                let mut plant = plant(scene.clone(), method, h);
                run_steps(&mut plant, 4 + (2.0 * entry / (spin * h)).ceil() as usize);
                let rise = totals(&plant).com_velocity.z;
                assert!(
                    (rise / expected - 1.0).abs() < tolerance,
                    "{method:?}, {spin} rad/s, h = {h}, phase {phase}: {rise} m/s instead of {expected}"
                );
            }
        }
    }
}

/// A point that starts on the ground, below or above the middle of its body, moves alike whether its height is zero or rounding. Its path within the step
/// presses some of these points down.
#[test]
fn a_point_on_the_ground_moves_alike_if_its_height_is_zero_or_rounding() {
    let seed = 5;
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    for trial in 0..200 {
        let mut draw = |from: f64, to: f64| from + (to - from) * random.f64();
        let at = Vector3::new(draw(-0.2, 0.2), draw(-0.2, 0.2), if trial % 2 == 0 { -0.2 } else { 0.2 });
        let spin = Vector3::new(draw(-15.0, 15.0), draw(-15.0, 15.0), draw(-5.0, 5.0));
        let mut scene = body([0.3, 0.2, 0.1], vec![at.into()]);
        (scene.plant.gravity, scene.plant.friction) = (9.81, 0.5);
        let slow = Vector3::new(draw(-1.0, 1.0), draw(-1.0, 1.0), draw(-0.02, 0.06));
        (scene.initial.velocity, scene.initial.angular_velocity) = ((slow - spin.cross(&at)).into(), spin.into());
        let ends = [-1e-16, 0.0, 1e-16].map(|height| {
            scene.initial.position = [0.0, 0.0, height - at.z];
            let mut plant = plant(scene.clone(), Method::MidpointContact, 1e-3);
            run_steps(&mut plant, 3);
            plant
        });
        let apart = distance(&ends[0], &ends[1]).max(distance(&ends[2], &ends[1]));
        assert!(apart < 1e-9, "trial {trial}: {apart:e}");
    }
}

/// A rod turns over its tip on ground without friction. The load of the tip falls to zero, and the tip leaves the ground: the acceleration is continuous,
/// but it bends. Until then `Rk4Impact` is a thousand times more accurate, and beyond it of second order. `EventDriven` takes shorter steps there.
#[test]
fn a_contact_that_opens_under_load_is_of_second_order_by_rk4_impact() {
    let (half, lean, rate): (f64, f64, f64) = (0.2, -60.0, 8.5);
    let mut scene = body([0.02, 0.02, 2.0 * half], vec![[0.0, 0.0, -half]]);
    (scene.plant.gravity, scene.plant.friction, scene.plant.base) = (G, 0.0, Base::Planar);
    scene.initial.clearance = Some(0.0);
    scene.initial.orientation_deg = [0.0, lean, 0.0];
    scene.initial.angular_velocity = [0.0, rate, 0.0];
    scene.initial.velocity = [0.0, 0.0, -rate * half * lean.to_radians().sin()];
    let end = |method: Method, dt: f64, time: f64| {
        let mut plant = plant(scene.clone(), method, dt);
        run_steps(&mut plant, (time / dt).round() as usize);
        plant
    };
    let errors = |time: f64| {
        let exact = end(Method::EventDriven, 1e-3, time);
        let of_rk4 = [4e-3, 5e-4].map(|dt| distance(&end(Method::Rk4Impact, dt, time), &exact));
        let least = end(Method::EventDriven, 4e-3, time);
        println!(
            "after {time} s the tip is {:.1e} m high: errors {of_rk4:?}, {:e}",
            gap(&exact),
            distance(&least, &exact)
        );
        assert!(distance(&least, &exact) < 1e-8, "EventDriven: {:e}", distance(&least, &exact));
        (gap(&exact), of_rk4)
    };
    let [(on_ground, before), (above, beyond)] = [0.024, 0.16].map(errors);
    let slope = (beyond[0] / beyond[1]).log2() / 3.0; // 4 ms are eight times .5 ms
    println!("order {slope:.2}");
    assert!(on_ground < 1e-9 && above > 1e-3, "{on_ground}, {above}");
    assert!(before[0] < 3e-3 * beyond[0] && (1.5..2.5).contains(&slope), "{before:?}, {beyond:?}");
}
