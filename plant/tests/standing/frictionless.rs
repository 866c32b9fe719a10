//! Frictionless ground: what stands on it slides away under any push.

use crate::totals;
use biped_plant::Plant;
use messages::load::parse;
use messages::scene::{Law, Method};
use messages::wire::Torques;

/// Bodies that stand on level ground, each with mass.
const STANDING: [&str; 3] = [
    "[[bodies]]
    name = \"box\"
    mass = 4.0
    size = [0.6, 0.4, 0.2]
    contacts = [[0.3, 0.2, -0.1], [0.3, -0.2, -0.1], [-0.3, 0.2, -0.1], [-0.3, -0.2, -0.1]]",
    "[[bodies]]
    name = \"ball\"
    mass = 4.0
    size = [0.2, 0.2, 0.2]
    spheres = [{ at = [0.0, 0.0, 0.0], radius = 0.1 }]",
    "[[bodies]]
    name = \"table\"
    mass = 2.0
    size = [0.4, 0.4, 0.1]
    [[bodies]]
    name = \"left\"
    mass = 1.0
    size = [0.1, 0.1, 0.1]
    joint = { parent = \"table\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.15, -0.1], stiffness = 300.0, damping = 3.0 }
    contacts = [[0.1, 0.05, -0.1], [0.1, -0.05, -0.1], [-0.1, 0.05, -0.1], [-0.1, -0.05, -0.1]]
    [[bodies]]
    name = \"right\"
    mass = 1.0
    size = [0.1, 0.1, 0.1]
    joint = { parent = \"table\", axis = [0.0, 1.0, 0.0], at = [0.0, -0.15, -0.1], stiffness = 300.0, damping = 3.0 }
    contacts = [[0.1, 0.05, -0.1], [0.1, -0.05, -0.1], [-0.1, 0.05, -0.1], [-0.1, -0.05, -0.1]]",
];

/// Momentum along the ground over the impulse of the push that began after .05 s, and the greatest force of friction [N].
fn slide(bodies: &str, friction: f64, law: Law, method: Method) -> (f64, f64) {
    const PUSH: f64 = 0.4; // [N·s]
    let mut scene = parse(&format!("[initial]\nclearance = 0.0\n{bodies}"), "a test").expect("a scene");
    (scene.plant.friction, scene.plant.law, scene.plant.method) = (friction, law, method);
    (scene.plant.dt, scene.rate) = (1e-3, 1e3);
    let mut plant = Plant::new(&scene).expect("a plant");
    let mut most = 0.0_f64;
    for period in 0..150 {
        if period == 50 {
            assert!(plant.push(0, [PUSH, 0.0, 0.0], 0.05), "it has a body");
        }
        plant.advance(&Torques::default()).expect("a step");
        let force = plant.truth().contact_force;
        let size =
            |force: &[f64]| if force.iter().all(|f| f.is_finite()) { force[0].hypot(force[1]) } else { f64::INFINITY };
        most = force.chunks_exact(3).map(size).fold(most, f64::max);
    }
    (totals(&plant).linear.x / PUSH, most)
}

/// Whatever stood in the step before is tried as standing first. Its friction was 0/0 where no contact can bear any, which is not greater than the
/// limit: so feet were glued to the ground, and the certificate, which measures velocities, was 0.
#[test]
fn what_stands_on_frictionless_ground_slides_away_under_a_push() {
    for (index, bodies) in STANDING.into_iter().enumerate() {
        for friction in [0.0, 1e-300, 1e-30, 1e-12] {
            let run = |law, method| {
                let (momentum, force) = slide(bodies, friction, law, method);
                assert!(
                    (momentum - 1.0).abs() < 1e-8 && force <= 1e-8,
                    "body {index}, friction {friction:e}, {law}, {method:?}: {momentum} of the impulse, friction of {force} N"
                );
            };
            for method in Method::ALL {
                run(Law::Cone, method);
            }
            for law in [Law::Aligned, Law::Complementarity, Law::Facets(8), Law::EnergyQp] {
                run(law, Method::SemiImplicitEuler);
            }
        }
    }
}
