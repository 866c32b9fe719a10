//! Dampers: the limit of stability of explicit methods, and the decay in a step of the others.

use biped_plant::Plant;
use messages::scene::{Method, Scene};
use messages::wire::Torques;

/// A rod of inertia 1 kg·m² about its fixed hinge, with this spring [N·m/rad] and damper [N·m·s/rad], turning at .1 rad/s.
fn rod(method: Method, stiffness: f64, damping: f64) -> Scene {
    let text = format!(
        "[plant]\nbase = \"fixed\"\ngravity = 0.0\ndrive_inertia = 0.0\n[initial]\njoint_rates = [0.1]\n[[bodies]]\nname = \"wall\"\nmass = 1.0\n\
         size = [0.1, 0.1, 0.1]\n[[bodies]]\nname = \"rod\"\nmass = 1.0\nsize = [0.1, 0.1, 0.1]\ninertia = [1.0, 1.0, 1.0]\njoint = {{ \
         parent = \"wall\", axis = [0.0, 1.0, 0.0], at = [0.0, 0.0, 0.0], stiffness = {stiffness:e}, damping = {damping:e} }}\n"
    );
    let mut scene = messages::load::parse(&text, "a test").expect("a scene");
    (scene.plant.method, scene.plant.dt, scene.rate) = (method, 1e-3, 1e3);
    scene
}

/// Just below its limit of h d/H a damper brings the joint to rest; just above it the scene is refused. Without the refusal each step would
/// turn the joint back by more than it had turned.
#[test]
fn a_damper_is_refused_from_the_step_at_which_it_would_add_energy() {
    for (method, limit) in
        [(Method::ExplicitEuler, 2.0), (Method::MoreauJean, 2.0), (Method::Rk4, 2.78), (Method::Rk4Impact, 2.78)]
    {
        let at = |part: f64| {
            Plant::new(&rod(method, 0.0, part * limit / 1e-3)).map(|mut plant| {
                (0..2000).for_each(|_| _ = plant.advance(&Torques::default()).expect("a step"));
                plant.state().xdot[0].abs()
            })
        };
        let [below, above] = [0.99, 1.01].map(at);
        println!("{method:?}: {below:?} rad/s after 2000 steps, {above:?}");
        assert!(below.as_ref().is_ok_and(|rate| *rate < 1e-6), "{method:?}: {below:?}");
        assert!(above.is_err_and(|error| error.to_string().contains("of the joint of body `rod`")), "{method:?}");
    }
}

/// An undamped spring grows by ½h²k/H per step under the explicit method of Euler. With h k = d it does not.
#[test]
fn a_spring_whose_oscillation_would_grow_in_every_step_is_refused() {
    for (stiffness, damping, accepted) in [(1.0, 0.0, false), (1e4, 0.0, false), (1e4, 9.99, false), (1e4, 10.0, true)]
    {
        let energy = Plant::new(&rod(Method::ExplicitEuler, stiffness, damping)).map(|mut plant| {
            (0..2000).for_each(|_| _ = plant.advance(&Torques::default()).expect("a step"));
            0.5 * plant.state().xdot[0].powi(2) + 0.5 * stiffness * plant.state().x[0].powi(2)
        });
        println!("{stiffness:e} N·m/rad, {damping} N·m·s/rad: {energy:?} J of .005 J");
        match accepted {
            true => assert!(energy.is_ok_and(|energy| energy < 0.006), "{stiffness:e}, {damping}"),
            false => assert!(energy.is_err_and(|error| error.to_string().contains("of the joint of body `rod`"))),
        }
    }
}

/// A rate that has decayed to 1e-159 has an error estimate whose square is 0. Without a rule for that case the method ended with 0/0. The
/// shortest step of its error control is dt/10000. If even that step is unstable, the scene is refused.
#[test]
fn the_event_driven_method_stops_a_damped_joint_or_refuses_the_damper() {
    for (damping, steps) in [(1e3, 1000), (1e5, 100), (1e7, 5), (5.8e7, 5)] {
        let mut plant = Plant::new(&rod(Method::EventDriven, 0.0, damping)).expect("a scene");
        (0..steps).for_each(|_| _ = plant.advance(&Torques::default()).expect("a step"));
        let (angle, rate) = (plant.state().x[0], plant.state().xdot[0]);
        println!("{damping:e}: {rate:e} rad/s at {angle:e} rad, {:?}", plant.counts());
        assert!(rate.abs() < 1e-9 && (angle * damping / 0.1 - 1.0).abs() < 1e-6, "{damping:e}: {rate:e}, {angle:e}");
    }
    for damping in [6e7, 1e9, 1e12] {
        let error = Plant::new(&rod(Method::EventDriven, 0.0, damping)).err().expect("a refusal").to_string();
        println!("{error}");
        assert!(
            error.contains("take a shorter plant.dt, or a method that has springs and dampers implicit"),
            "{error}"
        );
    }
}

/// The methods of second order that have dampers implicit.
const MIDPOINT: [Method; 3] = [Method::MidpointContact, Method::MidpointMoreau, Method::ImplicitMidpoint];

/// Factor of the rod's rate in one step of a method, for z = h d/H.
fn decay(method: Method, z: f64) -> f64 {
    let mut plant = Plant::new(&rod(method, 0.0, z / 1e-3)).expect("a scene");
    plant.step().expect("a step");
    plant.state().xdot[0] / 0.1
}

/// The exact factor is e^−z. A weight of ½ for the end of the step would miss it by z³/12.
#[test]
fn a_weak_damper_slows_its_joint_by_the_exponential_up_to_the_third_power_of_the_step() {
    for method in MIDPOINT {
        for z in [0.03, 0.1, 0.3, 1.0] {
            let missed = decay(method, z) - (-z).exp();
            println!("{method:?}, z = {z}: {missed:e}, z⁴/72 = {:e}", z.powi(4) / 72.0);
            assert!(missed.abs() < z.powi(4) / 60.0, "{method:?}, z = {z}: {missed:e}");
        }
    }
}

/// The factor is −2/z in the limit. With a weight of ½ it would be −1: the rate of the joint would change its sign in every step.
#[test]
fn a_strong_damper_stops_its_joint_in_one_step() {
    for method in MIDPOINT.into_iter().chain([Method::SemiImplicitEuler, Method::StepDoubling]) {
        for z in [10.0, 1e2, 1e4, 1e6] {
            let left = decay(method, z);
            println!("{method:?}, z = {z}: {left:e} of the rate is left");
            assert!(left.abs() < 3.0 / z, "{method:?}, z = {z}: {left:e}");
        }
    }
}

/// A limb of 10 kg on a light base in flight: the damper acts on the reduced mass, which is that of the base. By the entry of H alone, that of
/// the limb, z would be too small by their ratio.
#[test]
fn a_strong_damper_stops_a_heavy_limb_on_a_light_base() {
    for method in MIDPOINT.into_iter().chain([Method::SemiImplicitEuler, Method::StepDoubling]) {
        for ratio in [1.0, 1e2, 1e4] {
            let text = format!(
                "[plant]\ngravity = 0.0\n[initial]\njoint_rates = [0.1]\n[[bodies]]\nname = \"base\"\nmass = {:e}\nsize = [0.1, 0.1, 0.1]\n\
                 [[bodies]]\nname = \"limb\"\nmass = 10.0\nsize = [0.1, 0.1, 0.1]\njoint = {{ parent = \"base\", kind = \"prismatic\", \
                 axis = [1.0, 0.0, 0.0], at = [0.0, 0.0, 0.0], damping = {:e} }}\n",
                10.0 / ratio,
                1e2 * 1e3 * 10.0 / (ratio + 1.0), // z = h d/m = 100 with the reduced mass
            );
            let mut scene = messages::load::parse(&text, "a test").expect("a scene");
            (scene.plant.method, scene.plant.dt, scene.rate) = (method, 1e-3, 1e3);
            let mut plant = Plant::new(&scene).expect("a scene");
            (0..3).for_each(|_| _ = plant.advance(&Torques::default()).expect("a step"));
            let left = plant.state().joint_rate(plant.model(), 0) / 0.1;
            println!("{method:?}, ratio {ratio:e}: {left:e} of the rate is left after three steps");
            assert!(left.abs() < 1e-3, "{method:?}, ratio {ratio:e}: {left:e}");
        }
    }
}
