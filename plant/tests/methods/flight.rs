//! Flight: order, energy, momentum, and orientations where virtual joints fail.

use crate::support::{body, distance, go, plant, totals, tumbling};
use messages::scene::{Base, Method};

#[test]
fn every_method_has_its_order_in_flight() {
    let exact = {
        let mut scene = tumbling(Base::Quaternion);
        scene.plant.tolerance_step = 1e-14;
        let mut plant = plant(scene, Method::EventDriven, 0.01);
        go(&mut plant, 50);
        plant
    };
    for method in Method::ALL {
        let error = |dt: f64| {
            let mut plant = plant(tumbling(Base::Quaternion), method, dt);
            go(&mut plant, (0.5 / dt).round() as usize);
            distance(&plant, &exact)
        };
        let errors = [0.01, 0.005, 0.0025].map(error);
        println!(
            "{method:?}: errors {errors:?}, order {:.3} {:.3}",
            (errors[0] / errors[1]).log2(),
            (errors[1] / errors[2]).log2()
        );
    }
}
