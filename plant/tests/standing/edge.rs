//! A table that leans until a leg carries nothing, and until it tips.

use crate::totals;
use biped_plant::Plant;
use messages::robot::Body;
use messages::scene::{Base, Law, Scene};
use messages::wire::Torques;
use nalgebra::Vector3;

const MU: f64 = 0.9;
const WEIGHT: f64 = 5.0 * 9.81;
const HEIGHT: f64 = 0.4;
const LEGS: [[f64; 2]; 4] = [[0.2, 0.1], [0.2, -0.1], [-0.2, 0.1], [-0.2, -0.1]];

fn table(law: Law, friction: f64) -> Plant {
    let legs = LEGS.map(|[x, y]| [x, y, -HEIGHT]);
    let body =
        Body { name: "table".into(), mass: 5.0, size: [0.4, 0.2, 0.1], contacts: legs.into(), ..Body::default() };
    let mut scene = Scene { bodies: vec![body], ..Scene::default() };
    (scene.plant.base, scene.plant.friction, scene.plant.gravity) = (Base::Quaternion, friction, 9.81);
    scene.plant.law = law;
    (scene.plant.dt, scene.rate) = (1e-3, 1e3);
    scene.initial.clearance = Some(0.0);
    Plant::new(&scene).expect("a table")
}

/// A push at the centre of mass moves the centre of pressure by height · push/weight: to a point on the line between two legs, to the line
/// where one of four legs carries nothing, and slightly beyond. Every leg's force obeys Coulomb's law, and together they balance the
/// momentum.
#[test]
fn legs_obey_the_law_and_balance_the_momentum_of_a_leaning_table() {
    let seed = fastrand::u64(..);
    println!("seed {seed}");
    let mut random = fastrand::Rng::with_seed(seed);
    let (mut stood, mut tipped, mut worst) = (0, 0, [0.0_f64; 2]);
    for _ in 0..3000 {
        let mut plant = table(Law::Cone, MU);
        let mut step = |push: [f64; 2]| {
            assert!(plant.push(0, [1e-3 * push[0], 1e-3 * push[1], 0.0], 1e-3), "a table");
            let before = totals(&plant);
            plant.advance(&Torques::default()).expect("a step");
            let after = totals(&plant);
            let force = plant.truth().contact_force;
            let (mut sum, mut moment) = (Vector3::new(push[0], push[1], -WEIGHT), Vector3::zeros());
            let held = plant.problem().delassus.is_empty();
            let known = if held { 0.0 } else { 1e-10 * WEIGHT }; // contact by contact, the solution has the residual of a step
            for (f, [x, y]) in force.chunks_exact(3).zip(LEGS) {
                let f = Vector3::from_column_slice(f);
                let within = f.z >= -known && f.xy().norm() <= MU * f.z * (1.0 + 1e-12) + known;
                assert!(within, "{f:?} at {x}, {y}, pushed by {push:?}");
                (sum, moment) = (sum + f, moment + Vector3::new(x, y, -HEIGHT).cross(&f));
            }
            let linear = (after.linear - before.linear - sum * 1e-3).amax() / (1e-3 * WEIGHT);
            let angular = (after.angular - before.angular - moment * 1e-3).amax() / (1e-3 * WEIGHT * HEIGHT);
            (linear, angular, held, after.angular.amax())
        };
        (0..3).for_each(|_| _ = step([0.0; 2]));
        let offset = 10_f64.powf(-2.0 - 10.0 * random.f64()) * if random.bool() { 1.0 } else { -1.0 };
        let (along, tips) = (0.1 + 0.8 * random.f64(), random.bool());
        let turned = [(); 2].map(|()| if random.bool() { 1.0 } else { -1.0 });
        let [x, y] = if tips { [1.0, along] } else { [along, 1.0 - along] };
        let lean = |part: f64, k: usize| part * turned[k] * LEGS[0][k] * (1.0 + offset) * WEIGHT / HEIGHT;
        let (linear, angular, held, turns) = step([lean(x, 0), lean(y, 1)]);
        worst = [worst[0].max(linear), worst[1].max(angular)];
        stood += usize::from(held);
        tipped += usize::from(turns > 1e-13);
        assert!(linear < 1e-9 && angular < 1e-9, "{offset:e}, {tips}, {held}: {linear:e} {angular:e}");
        assert!(held || tips && offset > 0.0, "a table that stands is held, {offset:e}");
    }
    println!("{stood} of 3000 held, {tipped} tipped; momentum off by {worst:?}");
    assert!(stood > 2000 && tipped > 300, "{stood} held, {tipped} tipped");
}

/// Standing feet do not know the direction of a square cone. So they hold a foot only within the disc that every square contains, of radius
/// μ/√2. Beyond it the table stands as well, but contact by contact.
#[test]
fn feet_stand_within_the_disc_that_their_cone_contains() {
    let friction = 0.2; // the table slips before it tips
    for (law, part, held) in [
        (Law::Aligned, 0.69, true),
        (Law::Aligned, 0.73, false),
        (Law::Cone, 0.73, true),
        (Law::Cone, 0.9995, true),
        (Law::Cone, 1.0005, false),
    ] {
        for turn in 0..24 {
            let mut plant = table(law, friction);
            (0..3).for_each(|_| _ = plant.advance(&Torques::default()).expect("it stands"));
            let (sin, cos) = (std::f64::consts::TAU / 24.0 * f64::from(turn)).sin_cos();
            let push = 1e-3 * part * friction * WEIGHT;
            assert!(plant.push(0, [push * cos, push * sin, 0.0], 1e-3));
            plant.advance(&Torques::default()).expect("a step");
            assert_eq!(
                plant.problem().delassus.is_empty(),
                held,
                "{law}, {part} of the friction, direction {turn} of 24"
            );
        }
    }
}
