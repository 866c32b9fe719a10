//! Claims about the reduced model: the same motion, loads and zero-moment point, with fewer coordinates and contacts.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_plant::Plant;
use biped_plant::kinematics::{self, Pose};
use biped_plant::smallest::{Size, smallest};
use messages::load::{SCENES, built_in};
use messages::scene::{Base, Method, Scene};
use messages::wire::Torques;
use nalgebra::{Vector2, Vector3};

/// Part of the weight below which the zero-moment point is not compared.
const LOADED: f64 = 0.01;
/// Bound of a force that no law determines.
const UNDETERMINED: f64 = f64::INFINITY;
/// Time over which both models are compared [s].
const COMPARED_TIME: f64 = 0.6;

fn scene(name: &str) -> Scene {
    built_in(name).expect("a good scene")
}

/// Every scene without a controller.
fn scenes() -> Vec<(&'static str, Scene)> {
    let alone = |(_, scene): &(&str, Scene)| scene.controller.is_none();
    SCENES.iter().map(|&(name, _)| (name, scene(name))).filter(alone).collect()
}

/// Observable quantities of a model at the end of a control period.
struct Observables {
    /// Centres of mass [m], their velocities [m/s] and angular velocities [rad/s], body by body.
    motion: [Vec<Vector3<f64>>; 3],
    /// Force on each body [N], the mean over the period.
    force: Vec<Vector3<f64>>,
    /// Zero-moment point [m], and the load [N].
    zmp: (Vector2<f64>, f64),
}

fn observables(plant: &Plant) -> Observables {
    let (model, truth) = (plant.model(), plant.truth());
    let pose = Pose::of(model, plant.state());
    let links: Vec<_> = model.body_link.iter().map(|&link| &pose.links[link]).collect();
    let of =
        |part: fn(&Pose, &kinematics::LinkPose) -> Vector3<f64>| links.iter().map(|link| part(&pose, link)).collect();
    let motion = [
        of(|pose, link| pose.reference + link.com),
        of(|_, link| link.velocity.at(&link.com)),
        of(|_, link| link.velocity.angular),
    ];
    let mut force = vec![Vector3::zeros(); model.links.len()];
    let (mut load, mut moment) = (0.0, Vector2::zeros());
    for (point, on) in model.contact_points.iter().zip(truth.contact_force.chunks_exact(3)) {
        force[point.link] += Vector3::from_column_slice(on);
        load += on[2];
        moment += on[2] * (pose.reference + pose.lowest(point)).xy();
    }
    let force = model.body_link.iter().map(|&link| force[link]).collect();
    Observables { motion, force, zmp: (moment / load, load) }
}

/// Greatest differences of two models of a scene, each relative to its scale. A length: the robot's length, or its distance from the
/// origin. A speed: that of a fall from this height, or the present one. A rate: that speed by the size of the robot. A force: the weight,
/// or the greatest force so far.
#[derive(Clone, Copy, Debug, Default)]
struct Difference {
    motion: f64,
    /// Force on each body in the plane of x and z, and across it.
    force: [f64; 2],
    zmp: f64,
    /// Number of periods with load on the ground.
    loaded: usize,
    /// Greatest residual of the contact problems of both models.
    residual: f64,
}

fn difference(full: &Scene, small: &Scene) -> Difference {
    let mut plants = [full, small].map(|scene| Plant::new(scene).expect("a good scene"));
    let model = plants[0].model();
    let norm = |v: [f64; 3]| Vector3::from(v).norm();
    let arms = full.bodies.iter().flat_map(|body| {
        let joint = body.joint.iter().map(|joint| joint.at);
        body.contact_spheres().map(|touch| touch.at).chain([body.com, body.size]).chain(joint)
    });
    let size = arms.map(norm).fold(0.0, f64::max);
    let weight = model.mass() * model.gravity.norm();
    let (mut length, mut speed, mut force) =
        (size, (size * model.gravity.norm()).sqrt(), weight.max(f64::MIN_POSITIVE));
    let mut most = Difference::default();
    for _ in 0..(full.duration.min(COMPARED_TIME) * full.rate) as usize {
        for plant in &mut plants {
            plant.advance(&Torques::default()).expect("a period");
            most.residual = greater(most.residual, plant.truth().natural_map);
        }
        let [theirs, ours] = [&plants[0], &plants[1]].map(observables);
        let longest = |list: &[Vector3<f64>], least: f64| list.iter().map(Vector3::norm).fold(least, f64::max);
        (length, speed) = (longest(&theirs.motion[0], length), longest(&theirs.motion[1], speed));
        force = longest(&theirs.force, force);
        let gaps = |a: &[Vector3<f64>], b: &[Vector3<f64>]| a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<_>>();
        for (i, scale) in [length, speed, speed / size].into_iter().enumerate() {
            let gaps = gaps(&theirs.motion[i], &ours.motion[i]);
            most.motion = gaps.iter().fold(most.motion, |most, gap| greater(most, gap.norm() / scale));
        }
        for gap in gaps(&theirs.force, &ours.force) {
            most.force = [greater(most.force[0], gap.xz().norm() / force), greater(most.force[1], gap.y.abs() / force)];
        }
        if theirs.zmp.1.max(ours.zmp.1) > LOADED * weight {
            most.zmp = greater(most.zmp, (theirs.zmp.0 - ours.zmp.0).norm() / length);
            most.loaded += 1;
        }
    }
    most
}

/// The greater of two numbers, or NaN.
fn greater(a: f64, b: f64) -> f64 {
    if a.is_nan() || a > b { a } else { b }
}

/// The same motion to 1e-12, or to the residual of the contact problem. On the wheel, rounding decides whether the two points of a spoke
/// strike in one event or in two, and so where steps are split; there the motion agrees to the error of the method.
#[test]
fn every_scene_moves_the_same_on_its_smallest_model() {
    for (name, full) in scenes() {
        let plan = smallest(&full).expect("a good scene");
        if !plan.is_smaller() {
            println!("{name}: {}", plan.size);
            continue;
        }
        let most = difference(&full, &plan.scene);
        println!("{name}: {}, not {}: {most:?}", plan.size, plan.full);
        let bound = match name {
            "wheel" => {
                let mut exact = full.clone();
                exact.plant.method = Method::EventDriven;
                difference(&full, &exact).motion
            }
            _ => f64::max(1e-12, 10.0 * most.residual),
        };
        assert!(most.motion < bound && bound < 1e-5, "{name}: {most:?}, not within {bound:e}");
    }
}

/// The same force on every body and the same zero-moment point. No law determines the sideways force between two feet: only their ankles
/// turn across the plane, and the base of a planar model carries the rest. So for `stand0` only the force in its plane is compared.
#[test]
fn loads_and_zero_moment_point_are_those_of_the_full_model() {
    for (name, force) in [
        ("slide", [1e-9; 2]),
        ("stick", [1e-9; 2]),
        ("incline", [1e-9; 2]),
        ("drop", [1e-9; 2]),
        ("stand0", [1e-8, UNDETERMINED]),
    ] {
        let full = scene(name);
        let small = smallest(&full).expect("a good scene").scene;
        let most = difference(&full, &small);
        println!("{name}: {most:?}");
        assert!(most.loaded > 20 && most.zmp < 1e-9, "{name}: {most:?}");
        assert!(most.force[0] < force[0] && most.force[1] < force[1], "{name}: {most:?}");
    }
    // negative control: on one edge instead of the middle, the points carry the same load but give another zero-moment point
    let full = scene("slide");
    let mut edge = smallest(&full).expect("a good scene").scene;
    edge.bodies[0].contacts.iter_mut().for_each(|point| point[1] = full.bodies[0].contacts[0][1]);
    let most = difference(&full, &edge);
    assert!(most.motion < 1e-12 && most.zmp > 0.1, "{most:?}");
}

/// A contact has one row for its normal and one for each tangent.
#[test]
fn a_smaller_model_has_fewer_unknowns() {
    let unknowns = |size: &Size| [size.dofs, size.contacts * (1 + size.directions)];
    for (name, full) in scenes() {
        let plan = smallest(&full).expect("a good scene");
        let (ours, theirs) = (unknowns(&plan.size), unknowns(&plan.full));
        assert!(ours[0] <= theirs[0] && ours[1] <= theirs[1], "{name}: {ours:?} of {theirs:?}");
        assert_eq!(ours != theirs, plan.is_smaller(), "{name}");
        assert_eq!(plan.scene != full, plan.is_smaller(), "{name}");
    }
}

#[test]
fn each_rule_of_the_reduction_applies() {
    let size = |name: &str| smallest(&scene(name)).expect("a good scene").size;
    let of = |name: &str| (size(name).base, size(name).dofs, size(name).contacts, size(name).directions);
    assert_eq!(of("slide"), (Base::Planar, 3, 2, 1));
    assert_eq!(of("slide30"), (Base::Quaternion, 6, 4, 2), "it slides out of the plane");
    assert_eq!(of("wheel"), (Base::Planar, 3, 8, 1));
    assert_eq!(of("free"), (Base::Quaternion, 14, 0, 2), "it tumbles, and never comes down");
    assert_eq!(of("stand0"), (Base::Planar, 11, 8, 2), "a mirror image of itself, but its ankles roll");
    assert_eq!(of("drop").1, 3);
}

#[test]
fn a_scene_with_a_controller_is_not_reduced() {
    for name in ["walk", "stamp", "stand", "walk-literal", "paper"] {
        let full = scene(name);
        assert_eq!(smallest(&full).expect("a good scene").scene, full, "{name}");
    }
}

/// Negative controls: any of these breaks the symmetry of the scene.
#[test]
fn a_scene_that_is_not_symmetric_keeps_its_base() {
    let breaks: [fn(&mut Scene); 7] = [
        |scene| scene.initial.velocity[1] = 1e-9,
        |scene| scene.initial.orientation_deg[2] = 1.0,
        |scene| scene.initial.angular_velocity[0] = 0.1,
        |scene| scene.bodies[0].contacts[0][1] *= 1.01,
        |scene| scene.bodies[0].com[1] = 1e-6,
        |scene| scene.plant.push_impulse[1] = 1.0,
        |scene| scene.plant.payload_kg = 1.0,
    ];
    for (k, spoil) in breaks.into_iter().enumerate() {
        let mut spoilt = scene("slide");
        spoil(&mut spoilt);
        assert_eq!(smallest(&spoilt).expect("a good scene").size.base, Base::Quaternion, "break {k}");
    }
    let mut stand = scene("stand0");
    stand.initial.joints[3] += 1e-6;
    assert_eq!(smallest(&stand).expect("a good scene").size.base, Base::Quaternion);
}

#[test]
fn the_smallest_model_is_its_own_smallest_model() {
    for (name, full) in scenes() {
        let once = smallest(&full).expect("a good scene").scene;
        assert_eq!(smallest(&once).expect("a good scene").scene, once, "{name}");
    }
}

#[test]
fn the_reference_method_agrees_too() {
    for name in ["slide", "rock", "wheel", "stand0", "drop"] {
        let mut full = scene(name);
        (full.plant.method, full.plant.dt, full.rate) = (Method::EventDriven, 0.005, 200.0);
        let most = difference(&full, &smallest(&full).expect("a good scene").scene);
        println!("{name}: {most:?}");
        assert!(most.motion < 1e-12 && most.zmp < 1e-9, "{name}: {most:?}");
    }
}
