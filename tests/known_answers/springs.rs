//! Ground with springs and dampers: scene 18.

use crate::support::{assert_near, scene, threshold};
use messages::scene::Method;
use plant::Plant;

/// Whether a point on its spring stays near its rest position, after an initial offset of a thousandth.
fn is_stable(method: Method, damping_ratio: f64, step: f64) -> bool {
    let mut scene = scene("spring-ground", &[]);
    scene.plant.method = method;
    let rest = -9.81 / scene.plant.contact_stiffness;
    scene.initial.clearance = None;
    scene.initial.position = [0.0, 0.0, rest * 1.001];
    scene.plant.contact_damping_ratio = damping_ratio;
    scene.plant.dt = step / scene.plant.contact_stiffness.sqrt();
    let mut plant = Plant::new(&scene).expect("a point");
    // half a step ahead, where the midpoint method evaluates its forces: at the limit of stability the point is at rest at the end of every step
    let ahead = |plant: &Plant| plant.state().x[1] + 0.5 * scene.plant.dt * plant.state().xdot[1];
    (0..20_000).all(|_| plant.step().is_ok() && (ahead(&plant) / rest - 1.0).abs() < 0.1)
}

/// The paper's method and the default are stable on a spring of frequency ω and damping ratio ζ if and only if ω h < 2 (√(1 + ζ²) − ζ).
#[test]
fn a_spring_limits_the_stable_step() {
    for (damping_ratio, published) in [(0.0_f64, 2.0), (0.1, 1.810), (1.0, 0.8284)] {
        let exact = 2.0 * ((1.0 + damping_ratio * damping_ratio).sqrt() - damping_ratio);
        assert_near("published", exact, published, 5e-4);
        for method in [Method::SemiImplicitEuler, Method::MidpointContact] {
            let found = threshold(0.1, 3.0, |step| is_stable(method, damping_ratio, step));
            println!("{method:?}, damping ratio {damping_ratio}: omega h = {found}, {exact} by theory");
            assert_near("omega h", found, exact, 1e-3 * exact);
        }
    }
}
