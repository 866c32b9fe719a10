//! Slip in a steady direction, along which friction acts.

use crate::support::{plant, run_steps};
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
