//! Scenes that are simulated step by step, and the quantities that the tests check.

use messages::scene::Scene;
use messages::wire::Torques;
use nalgebra::Vector3;
use plant::Plant;
use plant::kinematics::{self, Pose, Totals};

/// Gravity [m/s²].
pub const G: f64 = 9.81;

/// A built-in scene or one of the tests, with changed values.
pub fn scene(name: &str, settings: &[&str]) -> Scene {
    let built_in = messages::load::SCENES.iter().any(|(known, _)| *known == name);
    let path = if built_in { name } else { &format!("{}/tests/data/{name}.toml", env!("CARGO_MANIFEST_DIR")) };
    let settings: Vec<_> = settings.iter().map(|setting| setting.to_string()).collect();
    messages::load::load(path, &settings, messages::load::SCENES).expect("a good scene")
}

/// The plant of a scene at time zero.
pub fn plant(name: &str, settings: &[&str]) -> Plant {
    Plant::new(&scene(name, settings)).expect("a scene that can be simulated")
}

/// Performs one step.
pub fn step(plant: &mut Plant) {
    plant.step().expect("a step");
}

/// Performs one control period; [`load`] returns its mean forces.
pub fn advance(plant: &mut Plant) {
    plant.advance(&Torques::default()).expect("a period");
}

/// Mean force of the ground on contact point i over the last control period [N].
pub fn load(plant: &Plant, i: usize) -> Vector3<f64> {
    Vector3::from_column_slice(&plant.truth().contact_force[3 * i..3 * i + 3])
}

/// Position of the base [m].
pub fn position(plant: &Plant) -> Vector3<f64> {
    pose(plant).point(plant.model().base_link, &Vector3::zeros())
}

/// The value between `low` and `high` at which `holds` changes, by bisection.
pub fn threshold(mut low: f64, mut high: f64, mut holds: impl FnMut(f64) -> bool) -> f64 {
    let at_low = holds(low);
    assert_ne!(at_low, holds(high), "nothing changes between {low} and {high}");
    while high - low > 1e-12 * high {
        let middle = 0.5 * (low + high);
        if holds(middle) == at_low { low = middle } else { high = middle }
    }
    high
}

/// Runs up to a simulated time [s].
pub fn run(plant: &mut Plant, until: f64) {
    while (plant.time_ns() as f64) < until * 1e9 - 0.5 {
        step(plant);
    }
}

/// Pose of the current state.
pub fn pose(plant: &Plant) -> Pose {
    Pose::of(plant.model(), plant.state())
}

/// Momentum and energy.
pub fn totals(plant: &Plant) -> Totals {
    kinematics::totals(plant.model(), plant.state(), &pose(plant))
}

/// Height of the lowest contact point [m].
pub fn clearance(plant: &Plant) -> f64 {
    let pose = pose(plant);
    let heights = plant.model().contact_points.iter().map(|corner| pose.reference.z + pose.lowest(corner).z);
    heights.fold(f64::INFINITY, f64::min)
}

/// Angular velocity of the base in the world frame [rad/s].
pub fn spin(plant: &Plant) -> Vector3<f64> {
    pose(plant).links[plant.model().base_link].velocity.angular
}

/// Asserts that a value is within a tolerance of its exact value.
#[track_caller]
pub fn assert_near(what: &str, value: f64, exact: f64, tolerance: f64) {
    assert!((value - exact).abs() <= tolerance, "{what}: {value:e}, not {exact:e}, off by {:e}", value - exact);
}
