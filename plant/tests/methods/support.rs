//! Scenes of the tests, and functions that run them.

use biped_plant::Plant;
use biped_plant::kinematics::{self, Pose, Totals};
use messages::load::parse;
use messages::robot::Body;
use messages::scene::{Base, Method, Scene};
use messages::wire::Torques;
use nalgebra::Vector3;

/// A plant that runs `scene` with this method in steps of `dt`, one per control period.
pub fn plant(mut scene: Scene, method: Method, dt: f64) -> Plant {
    (scene.plant.method, scene.plant.dt, scene.rate) = (method, dt, 1.0 / dt);
    Plant::new(&scene).expect("a good scene")
}

/// Takes this many steps.
pub fn run_steps(plant: &mut Plant, steps: usize) {
    for _ in 0..steps {
        plant.advance(&Torques::default()).expect("a step");
    }
}

pub fn totals(plant: &Plant) -> Totals {
    let pose = Pose::of(plant.model(), plant.state());
    kinematics::totals(plant.model(), plant.state(), &pose)
}

/// Kinetic and potential energy [J].
pub fn energy(plant: &Plant) -> f64 {
    let totals = totals(plant);
    totals.kinetic + totals.potential
}

/// Height of the lowest contact point [m].
pub fn gap(plant: &Plant) -> f64 {
    corners(plant).iter().map(|point| point.z).fold(f64::INFINITY, f64::min)
}

/// Greatest difference of two states' coordinates and rates.
pub fn distance(a: &Plant, b: &Plant) -> f64 {
    let pairs = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let (a, b) = (a.state(), b.state());
    f64::max(pairs(&a.x, &b.x), pairs(&a.xdot, &b.xdot))
}

/// The biped of Table 1 tumbling through space, drives without inertia.
pub fn tumbling(base: Base) -> Scene {
    let mut scene = Scene::default();
    scene.plant.base = base;
    scene.plant.gravity = 0.0;
    scene.plant.drive_inertia = 0.0;
    scene.initial.position[2] = 100.0;
    scene.initial.angular_velocity = [0.6, -0.8, 1.0];
    scene.initial.joint_rates = vec![0.8, -0.9, 1.0, -1.1, 1.2, -1.3, 1.4, -1.5];
    scene
}

/// One body on a quaternion base, without gravity.
pub fn body(size: [f64; 3], contacts: Vec<[f64; 3]>) -> Scene {
    let body = Body { name: "body".into(), mass: 1.0, size, contacts, ..Body::default() };
    let mut scene = Scene { bodies: vec![body], ..Scene::default() };
    scene.plant.base = Base::Quaternion;
    scene.plant.gravity = 0.0;
    scene
}

/// The eight corners of a box, the four upper ones first [m].
pub fn box_corners(size: [f64; 3]) -> Vec<[f64; 3]> {
    let corner = |k: usize| [0, 1, 2].map(|axis| if k >> axis & 1 == 0 { 0.5 } else { -0.5 } * size[axis]);
    (0..8).map(corner).collect()
}

/// A scene with steps of `dt`, one per control period.
pub fn scene_of(dt: f64, text: &str) -> Scene {
    let mut scene = parse(text, "a test").expect("a scene");
    (scene.plant.dt, scene.rate) = (dt, 1.0 / dt);
    scene
}

/// The plant of a scene after this time [s].
pub fn after(scene: &Scene, time: f64) -> Plant {
    let mut plant = Plant::new(scene).expect("a plant");
    run_steps(&mut plant, (time * scene.rate).round() as usize);
    plant
}

/// One of the built-in scenes.
pub fn built_in(name: &str) -> Scene {
    messages::load::built_in(name).expect("a good scene")
}

/// Position of every contact point [m].
pub fn corners(plant: &Plant) -> Vec<Vector3<f64>> {
    let pose = Pose::of(plant.model(), plant.state());
    plant.model().contact_points.iter().map(|point| pose.point(point.link, &point.at)).collect()
}

/// Distance along the ground [m].
pub fn ground_distance(from: &Vector3<f64>, to: &Vector3<f64>) -> f64 {
    (to - from).xy().norm()
}

/// The forces of the ground act at the contact points: with the arms of these about the centre of mass, they explain the change of angular
/// momentum. Returns the greatest part of the moments that does not, over a number of steps, and the number of those with a force.
pub fn missing_moment(plant: &mut Plant, steps: usize) -> (f64, usize) {
    let (mut worst, mut loaded) = (0.0_f64, 0);
    for _ in 0..steps {
        let (before, starts, time) = (totals(plant), corners(plant), plant.time_ns());
        run_steps(plant, 1);
        let (after, ends, dt) = (totals(plant), corners(plant), 1e-9 * (plant.time_ns() - time) as f64);
        let (mut moment, mut size) = (Vector3::zeros(), 0.0);
        for ((force, start), end) in plant.truth().contact_force.chunks_exact(3).zip(&starts).zip(&ends) {
            let impulse = Vector3::from_column_slice(force) * dt;
            let arm = 0.5 * (start - before.com + (end - after.com));
            (moment, size) = (moment + arm.cross(&impulse), size + arm.norm() * impulse.norm());
        }
        if size > 0.0 {
            worst = worst.max((after.angular - before.angular - moment).norm() / size);
            loaded += 1;
        }
    }
    (worst, loaded)
}
