//! Cases of motion without impacts from bug reports about other engines, with their correct values, under the default method.

use crate::support::{after, corners, run_steps, scene_of, totals};
use biped_plant::Plant;
use messages::scene::Method;

/// Nine rods on joints with this damper [N·m·s/rad], which turn in flight.
fn free_chain(damping: f64) -> String {
    let rest = |k: usize| {
        let axis = if k % 2 == 1 { "[1.0, 0.0, 0.0]" } else { "[0.0, 1.0, 0.0]" };
        format!(
            "[[bodies]]\nname = \"b{k}\"\nmass = 1.0\nsize = [0.05, 0.05, 0.3]\ncom = [0.0, 0.0, -0.15]\n\
             joint = {{ parent = \"b{}\", axis = {axis}, at = [0.0, 0.0, -0.3], damping = {damping:e} }}\n",
            k - 1
        )
    };
    let text = "[plant]\ngravity = 0.0\n[initial]\njoints = [0.4, -0.3, 0.5, -0.6, 0.2, 0.3, -0.4, 0.5]\n\
        joint_rates = [1.0, -2.0, 1.5, -0.5, 2.0, -1.0, 0.5, 1.0]\n[[bodies]]\nname = \"b0\"\nmass = 1.0\nsize = [0.05, 0.05, 0.3]\n\
        com = [0.0, 0.0, -0.15]\n";
    text.to_string() + &(1..9).map(rest).collect::<String>()
}

/// Cf. Bullet3 #2698: with the paper's step, 34 % of the momentum is gone at 5 s, and at 11.7 s the state is not finite.
#[test]
fn a_free_chain_keeps_momentum_and_energy() {
    let text = free_chain(0.0);
    let worst = [1e-3, 2.5e-4].map(|dt| {
        let mut plant = Plant::new(&scene_of(dt, &text)).expect("a chain");
        let start = totals(&plant);
        let mut worst = [0.0_f64; 2];
        for _ in 0..200 {
            run_steps(&mut plant, (0.1 / dt).round() as usize);
            let now = totals(&plant);
            let momentum = (now.linear - start.linear).norm() / start.linear.norm();
            worst = [worst[0].max((now.kinetic / start.kinetic - 1.0).abs()), worst[1].max(momentum)];
        }
        println!("dt {dt}, within 20 s: energy {:.1e}, momentum {:.1e}", worst[0], worst[1]);
        worst
    });
    // they oscillate by h², and do not drift
    assert!(worst[0].iter().all(|worst| *worst < 0.05) && worst[1].iter().all(|worst| *worst < 4e-3), "{worst:?}");
}

/// A damper that stops its joint within a step acts as a push within one step does: the chain moves while its velocity jumps. So the momentum is kept to
/// first order. With a damper that takes several steps it is kept to second order.
#[test]
fn a_damped_chain_keeps_its_momentum_to_second_order_and_one_that_stops_at_once_to_first() {
    let missing = |damping: f64, dt: f64| {
        let mut plant = Plant::new(&scene_of(dt, &free_chain(damping))).expect("a chain");
        let start = totals(&plant).linear;
        run_steps(&mut plant, (0.2 / dt).round() as usize);
        (totals(&plant).linear - start).norm() / start.norm()
    };
    for (damping, most, orders) in [(1.0, 1e-5, 1.9..2.1), (1e4, 2e-3, 0.9..1.2)] {
        let [coarse, fine] = [1e-3, 2.5e-4].map(|dt| missing(damping, dt));
        let order = 0.5 * (coarse / fine).log2();
        println!("{damping} N·m·s: {coarse:.1e} of the momentum at 1 ms, order {order:.2}");
        assert!(coarse < most && orders.contains(&order), "{damping} N·m·s: {coarse:e}, {fine:e}");
    }
}

/// A top on its tip, tilted by 30°.
const TOP: &str = "[plant]\nfriction = 100.0\n[initial]\nclearance = 0.0\norientation_deg = [0.0, 30.0, 0.0]\n\
    angular_velocity = [57.76300825, 0.0, 105.21457624]\n[[bodies]]\nname = \"top\"\nmass = 0.5\nsize = [0.1, 0.1, 0.1]\n\
    com = [0.0, 0.0, 0.1]\ninertia = [0.0006, 0.0006, 0.001]\ncontacts = [[0.0, 0.0, 0.0]]\n";

/// Cf. Principia #2250: 30°, 5.166111 rad/s about the vertical.
#[test]
fn a_heavy_top_stays_steady_on_its_tip() {
    let spread = |dt: f64| {
        let mut plant = Plant::new(&scene_of(dt, TOP)).expect("a top");
        let mut worst = [0.0_f64; 2];
        for _ in 0..(1.0 / dt) as usize {
            run_steps(&mut plant, 1);
            let com = totals(&plant).com - corners(&plant)[0];
            worst = [
                worst[0].max(((com.z / 0.1).acos().to_degrees() - 30.0).abs()),
                worst[1].max(corners(&plant)[0].norm()),
            ];
        }
        worst
    };
    let [coarse, fine] = [1e-3, 2.5e-4].map(spread);
    println!("tilt off by {:.3}° and {:.4}°, tip by {:.1e} and {:.1e} m", coarse[0], fine[0], coarse[1], fine[1]);
    assert!(coarse[0] < 0.5 && fine[0] < coarse[0] / 10.0, "{coarse:?} {fine:?}");
    assert!(coarse[1] < 1e-3 && fine[1] < coarse[1] / 10.0, "{coarse:?} {fine:?}");
}

/// It precesses at 5.166111 rad/s.
#[test]
fn a_heavy_top_precesses_at_the_exact_rate() {
    let precession = |dt: f64, method: Method| {
        let mut scene = scene_of(dt, TOP);
        scene.plant.method = method;
        let mut plant = Plant::new(&scene).expect("a top");
        let azimuth = |plant: &Plant| {
            let com = totals(plant).com - corners(plant)[0];
            com.y.atan2(com.x)
        };
        let start = azimuth(&plant);
        run_steps(&mut plant, (1.0 / dt) as usize);
        (azimuth(&plant) - start).rem_euclid(std::f64::consts::TAU)
    };
    let [default, exact] =
        [(2.5e-4, Method::MidpointContact), (1e-3, Method::EventDriven)].map(|(dt, m)| precession(dt, m));
    println!("precession {default:.5} and {exact:.6} rad in 1 s");
    assert!((default - 5.166111).abs() < 5e-3 && (exact - 5.166111).abs() < 1e-6, "{default}, {exact}");
}

/// A body that spins fast: with the paper's step, its energy grows eightfold within a second.
#[test]
fn a_fast_spin_keeps_its_energy() {
    let text = "[plant]\ngravity = 0.0\n[initial]\nangular_velocity = [40.0, 20.0, 90.0]\n[[bodies]]\nname = \"box\"\nmass = 1.0\n\
        size = [0.05, 0.2, 0.45]\ncontacts = []\n";
    let mut plant = Plant::new(&scene_of(1e-3, text)).expect("a box");
    let start = totals(&plant);
    run_steps(&mut plant, 20_000);
    let end = totals(&plant);
    let (energy, momentum) =
        (end.kinetic / start.kinetic - 1.0, (end.angular - start.angular).norm() / start.angular.norm());
    println!("after 20 s: energy {energy:.1e}, angular momentum {momentum:.1e}");
    assert!(energy.abs() < 1e-8 && momentum < 5e-3, "{energy:e} {momentum:e}");
}

/// Cf. DART #846: undamped, the energy is constant; with the paper's step a spring loses all of it.
#[test]
fn an_undamped_spring_keeps_its_energy() {
    let text = "[plant]\nbase = \"fixed\"\ngravity = 0.0\n[initial]\njoints = [0.1]\n[[bodies]]\nname = \"wall\"\nmass = 1.0\n\
        size = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"mass\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
        joint = { parent = \"wall\", kind = \"prismatic\", axis = [1.0, 0.0, 0.0], at = [0.0, 0.0, 0.0], stiffness = 1000.0 }\n";
    for (dt, limit) in [(1e-3, 1e-11), (2e-2, 1e-11)] {
        let plant = after(&scene_of(dt, text), 10.0);
        let (x, v) = (plant.state().x[0], plant.state().xdot[0]);
        let off = (500.0 * x * x + 0.5 * v * v) / 5.0 - 1.0;
        println!("dt {dt}: energy off by {off:.1e} after 10 s");
        assert!(off.abs() < limit, "dt {dt}: {off:e}");
    }
}

/// Cf. Drake #17077, DART #115: q(1) = .998680 rad. It decays within .03 ms, a thirtieth of a step.
#[test]
fn a_damper_much_stronger_than_its_joint_holds_in_every_method_or_is_refused() {
    let text = "[plant]\nbase = \"fixed\"\njoint_damping = 5.0\n[initial]\nposition = [0.0, 0.0, 1.0]\njoints = [1.0]\n[[bodies]]\n\
        name = \"hook\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"finger\"\nmass = 0.02\nsize = [0.02, 0.02, 0.08]\n\
        com = [0.0, 0.0, -0.04]\njoint = { parent = \"hook\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\n";
    let own = text
        .replace("joint_damping = 5.0\n", "")
        .replace("at = [0.0, 0.0, 0.0] }", "at = [0.0, 0.0, 0.0], damping = 5.0 }");
    for method in Method::ALL {
        let end = |text: &str| {
            let mut scene = scene_of(1e-3, text);
            scene.plant.method = method;
            Plant::new(&scene).map(|mut plant| {
                run_steps(&mut plant, 1000);
                plant.state().x[0]
            })
        };
        match (end(text), end(&own)) {
            (Ok(q), Ok(other)) => {
                println!("{method:?}: {q:.9} rad");
                assert!((q - 0.998_680).abs() < 1e-5 && q == other, "{method:?}: {q} {other}");
            }
            (Err(error), Err(_)) => {
                println!("{method:?}: {error}");
                assert!(error.to_string().contains("of the joint of body `finger`"), "{method:?}: {error}");
            }
            (of_plant, of_joint) => panic!("{method:?}: {of_plant:?} {of_joint:?}"),
        }
    }
}

#[test]
fn a_spring_and_damper_far_too_stiff_for_the_step_bring_the_joint_to_rest() {
    let text = "[plant]\nbase = \"fixed\"\ngravity = 0.0\n[initial]\njoints = [0.1]\n[[bodies]]\nname = \"h\"\nmass = 1.0\n\
        size = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"a\"\nmass = 1.0\nsize = [0.05, 0.05, 0.4]\ncom = [0.0, 0.0, -0.2]\n\
        inertia = [0.01, 0.01, 0.01]\n\
        joint = { parent = \"h\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0], stiffness = 1e6, damping = 1e4 }\n";
    // d/k = .01 s is the time constant of its return
    let right = 0.1 * (-10.0_f64).exp();
    for method in [Method::MidpointContact, Method::ImplicitMidpoint, Method::MidpointMoreau] {
        let mut scene = scene_of(1e-4, text);
        scene.plant.method = method;
        let q = after(&scene, 0.1).state().x[0];
        println!("{method:?}: {q:e} rad, right {right:e}");
        assert!((q - right).abs() < 2e-7, "{method:?}: {q:e}, right {right:e}");
    }
}

/// Cf. Drake #13657: T = 1.0036 s. Bodies have no drive inertia unless the scene gives one.
#[test]
fn a_pendulum_has_the_period_of_its_length() {
    let text = "[plant]\nbase = \"fixed\"\n[initial]\nposition = [0.0, 0.0, 2.0]\njoints = [0.01]\n[[bodies]]\nname = \"hook\"\n\
        mass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"bob\"\nmass = 0.1\nsize = [0.02, 0.02, 0.02]\ncom = [0.0, 0.0, -0.25]\n\
        joint = { parent = \"hook\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\n";
    let crossings = |text: &str| {
        let mut plant = Plant::new(&scene_of(5e-4, text)).expect("a pendulum");
        let mut times = Vec::new();
        for k in 0..20_000 {
            let before = plant.state().x[0];
            run_steps(&mut plant, 1);
            let after = plant.state().x[0];
            if before > 0.0 && after <= 0.0 {
                times.push(5e-4 * (f64::from(k) + before / (before - after)));
            }
        }
        times[1] - times[0]
    };
    let (bare, driven) = (crossings(text), crossings(&text.replace("base = ", "drive_inertia = 0.1\nbase = ")));
    println!("{bare} s; with drive inertia {driven} s");
    assert!((bare - 1.0036).abs() < 1e-4 && driven > 4.0, "{bare} {driven}");
}
