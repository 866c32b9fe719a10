//! Contacts that jam: friction presses them harder into the ground than their impulse lifts them.

use crate::support::{energy, plant, run_steps};
use messages::load::parse;
use messages::scene::Method;

/// A light base that carries a heavy slider, thrown. Where it slides steadily, friction along the slip would press the contact harder into
/// the ground than its impulse lifts it: the direction of the slip then changes at once.
#[test]
fn a_steady_slip_that_jams_is_solved_with_the_direction_that_results() {
    let mut random = fastrand::Rng::with_seed(3);
    for round in 0..40 {
        let mass = 10f64.powf(2.0 + 4.0 * random.f64());
        let mut vector = |size: f64| [0; 3].map(|_| size * (2.0 * random.f64() - 1.0));
        let ([a, b, c], at, size) = (vector(0.2), vector(0.2), vector(0.2).map(|side| 0.2 + side.abs()));
        let text = format!(
            "[plant]\nfriction = 0.8\n[initial]\nclearance = 0.0\norientation_deg = {:?}\nangular_velocity = {:?}\n[[bodies]]\n\
             name = \"base\"\nmass = 1.0\nsize = {size:?}\ncontacts = [[{a}, {b}, {c}], [{b}, {c}, {a}], [{c}, {a}, {b}]]\n[[bodies]]\n\
             name = \"slider\"\nmass = {mass}\nsize = {size:?}\ncom = {at:?}\ncontacts = [[{b}, {a}, {c}], {at:?}]\n\
             joint = {{ parent = \"base\", axis = [0.0, 1.0, 0.0], at = {at:?}, kind = \"prismatic\" }}\n",
            vector(180.0),
            vector(2.0)
        );
        let mut plant = plant(parse(&text, "a test").expect("a scene"), Method::MidpointContact, 1e-3);
        for _ in 0..600 {
            run_steps(&mut plant, 1);
            let map = plant.truth().natural_map;
            assert!(map < 1e-10, "seed 3, round {round}, slider of {mass} kg: natural map {map:e}");
        }
        assert_eq!(plant.truth().fallbacks, 0, "seed 3, round {round}, slider of {mass} kg");
    }
}

/// A rod on a hinge, whose tip lands at 48° to the ground. Above a friction of tan 48° = 1.12 the tip can neither leave the ground by a bounce nor be
/// moved out of it, because friction against that slip presses it down. Then it stops where it lands.
#[test]
fn a_rod_that_jams_stops_where_it_lands_by_every_method() {
    let text = "[plant]\nbase = \"fixed\"\n[initial]\nposition = [0.0, 0.0, 0.2]\njoints = [1.5]\n\
        [[bodies]]\nname = \"base\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
        [[bodies]]\nname = \"rod\"\nmass = 0.5\nsize = [0.02, 0.02, 0.3]\ncom = [0.0, 0.0, -0.15]\ncontacts = [[0.0, 0.0, -0.3]]\n\
        joint = { parent = \"base\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\n";
    for (method, e) in Method::ALL.into_iter().flat_map(|method| [(method, 0.0), (method, 0.5)]) {
        if e > 0.0 && !method.bounces() {
            continue;
        }
        for friction in [0.5, 1.2, 10.0, 1e6] {
            let mut scene = parse(text, "a test").expect("a scene");
            (scene.plant.friction, scene.plant.restitution) = (friction, e);
            let mut plant = plant(scene, method, 1e-3);
            let mut rise = 0.0_f64;
            for _ in 0..600 {
                run_steps(&mut plant, 1);
                rise = rise.max(plant.state().xdot[0]);
            }
            let (q, at) = (plant.state().x[0], (2.0_f64 / 3.0).acos());
            println!("{method:?}, e = {e}, μ = {friction}: {:.1e} rad off, {rise:.3} rad/s upwards", q - at);
            let bounces = e > 0.0 && friction < 1.0;
            assert!(bounces == (rise > 1.0), "{method:?}, e = {e}, μ = {friction}: {rise} rad/s upwards");
            assert_eq!(plant.truth().fallbacks, 0, "{method:?}, e = {e}, μ = {friction}");
            let pivots = plant.truth().pivots; // a search for a way out of the ground takes thousands
            assert!(pivots < 100, "{method:?}, e = {e}, μ = {friction}: {pivots} linear systems in a step at rest");
            let two_steps = 2.0 * 4.0 * 1e-3; // ExplicitEuler stops a landing within two steps, at up to 4 rad/s
            assert!((q - at).abs() < two_steps, "{method:?}, e = {e}, μ = {friction}: {q} rad instead of {at}");
        }
    }
}

/// Arms of 1 kg that fall from a random angle. A landing is located to 1e-5 of a step, so the tip may end nanometres inside the ground. Where
/// friction jams it there, no impulse moves it out. But the rounding of a huge one along the arm would hide that it does not move.
#[test]
fn a_tip_that_jams_nanometres_inside_the_ground_carries_its_load() {
    let mut random = fastrand::Rng::with_seed(5);
    for round in 0..60 {
        let [angle, rate, friction] = [[0.3, 1.4], [0.0, 3.0], [0.3, 5.0]].map(|[a, b]| a + (b - a) * random.f64());
        let text = format!(
            "[plant]\nbase = \"fixed\"\nfriction = {friction}\n[initial]\nclearance = 0.01\njoints = [{angle}]\njoint_rates = [{rate}]\n\
             [[bodies]]\nname = \"post\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n\
             [[bodies]]\nname = \"arm\"\nmass = 1.0\nsize = [0.05, 0.05, 0.4]\ncom = [0.0, 0.0, -0.2]\ncontacts = [[0.0, 0.0, -0.4]]\n\
             joint = {{ parent = \"post\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }}\n"
        );
        for method in Method::ALL {
            let mut plant = plant(parse(&text, "a test").expect("a scene"), method, 1e-3);
            let (mut force, mut map) = (0.0_f64, 0.0_f64);
            for _ in 0..300 {
                run_steps(&mut plant, 1);
                let truth = plant.truth();
                force = truth.contact_force[..3].iter().fold(force, |most, part| most.max(part.abs()));
                map = map.max(truth.natural_map);
            }
            let name = format!("seed 5, round {round}, {method:?}, {angle:.3} rad, μ = {friction:.2}");
            // a landing near the least friction that jams may take 1e4 N; the huge forces were from 1e9 N on
            assert!(force < 1e6, "{name}: {force:.1e} N on a tip of less than 1 kg");
            assert!(map <= 1e-10 && plant.truth().fallbacks == 0, "{name}: natural map {map:.1e}");
        }
    }
}

/// An arm that begins 5 mm inside the ground at 17°. At a friction of .7 no force brings it out: friction holds it there. Methods that look for forces
/// in each stage do not look again while it rests.
#[test]
fn a_jam_that_rests_is_not_proven_again_in_every_step() {
    let text = "[plant]\nbase = \"fixed\"\nfriction = 0.7\n[initial]\nposition = [0.0, 0.0, 0.2]\njoints = [0.3]\n[[bodies]]\n\
        name = \"post\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"arm\"\nmass = 1.0\nsize = [0.1, 0.1, 0.4]\n\
        com = [0.0, 0.0, -0.1]\ncontacts = [[0.0, 0.0, -0.215]]\n\
        joint = { parent = \"post\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0] }\n";
    for method in [Method::MidpointContact, Method::Rk4Impact, Method::EventDriven] {
        let mut plant = plant(parse(text, "a test").expect("a scene"), method, 1e-3);
        run_steps(&mut plant, 2);
        let before = plant.counts();
        run_steps(&mut plant, 100);
        let (after, pivots, q) = (plant.counts(), plant.truth().pivots, plant.state().x[0]);
        let evaluations = after.evaluations - before.evaluations;
        println!("{method:?}: {evaluations} evaluations in 100 steps, {pivots} linear systems in the last, at {q} rad");
        assert!(evaluations <= 200 && pivots < 10 && q == 0.3, "{method:?}: {evaluations}, {pivots}, {q}");
    }
}

/// Posts that topple over an edge and turn about the vertical: their two corners rub against each other, and the forces grow beyond all bounds before
/// the corners jam. Without a bound on forces and on the energy that they make, each of these posts is thrown by one of the methods.
#[test]
fn a_post_that_topples_over_its_edge_and_turns_is_not_thrown() {
    const BOUNDED: [f64; 3] = [0.198_699_377_122_402_5, 0.1845488611375938, 0.6647837110731831];
    let posts = [
        // size [m], tilt [°], rate about the vertical [rad/s], friction, time [s]
        ([0.1, 0.1, 0.5], 20.0, 0.5, 1.0, 0.25),
        ([0.1, 0.1, 0.5], 25.0, 1.0, 1.0, 0.25),
        ([0.1, 0.1, 0.15], 30.0, 0.5, 1.5, 0.25),
        // great forces in a stage, which the sum of the stages hides: without the bound on forces it is thrown
        ([0.2, 0.2, 1.2], 18.0, 0.5, 1.0, 0.4),
        // forces within that bound: without the bound on energy it is thrown
        (BOUNDED, 26.92619020937917, 0.6002840310892457, 1.4929512872203956, 0.15),
    ];
    for (size, tilt, turn, friction, time) in posts {
        let [x, y, z] = size.map(|side: f64| 0.5 * side);
        let corners = [[-x, -y, -z], [-x, y, -z], [x, -y, -z], [x, y, -z]];
        let text = format!(
            "[plant]\nfriction = {friction}\n[initial]\nclearance = 0.0\norientation_deg = [0.0, {tilt}, 0.0]\nangular_velocity = [0.0, 0.5, {turn}]\n\
             [[bodies]]\nname = \"post\"\nmass = 5.0\nsize = {size:?}\ncontacts = {corners:?}\n"
        );
        for method in [Method::EventDriven, Method::Rk4Impact] {
            for dt in [1e-3, 5e-4] {
                let mut plant = plant(parse(&text, "a test").expect("a scene"), method, dt);
                let start = energy(&plant);
                for step in 0..(time / dt) as usize {
                    run_steps(&mut plant, 1);
                    let gain = energy(&plant) / start - 1.0;
                    assert!(gain < 1e-3, "{size:?} by {method:?} at {dt} s: energy made {gain:e} in step {step}");
                }
            }
        }
    }
}
