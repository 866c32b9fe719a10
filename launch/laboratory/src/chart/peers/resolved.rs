//! The comparison scenes as other simulators read them: one TOML file, in which nothing is left to be derived.
//!
//! Every default is written out. The pose of the base is explicit instead of `clearance`, its origin is its centre of mass, every body
//! has its `inertia`, and joint axes that point along a negative axis are turned round together with their angles.

use crate::chart::cases::{self, CASES, Combination, ComparisonScene, LAW, METHOD, Question};
use crate::chart::steps::{H, LOADS};
use messages::scene::Scene;
use nalgebra::Vector3;
use plant::Plant;
use plant::kinematics::Pose;
use serde::Serialize;
use shared::exit::{Exit, Failure};

/// The first line of the file.
pub const HEAD: &str = "# Scenes for other simulators, written by `biped chart --peers`.\n";

/// The whole file.
#[derive(Serialize)]
struct ScenesFile {
    scenes: Vec<Entry>,
}

/// A scene and its measurements.
#[derive(Serialize)]
struct Entry {
    name: &'static str,
    /// Rows of a trace after the first; 0: one for each step.
    samples: usize,
    /// Steps of 1 ms whose time is the cost of a step; 0: not measured.
    timed_steps: usize,
    /// Whether errors are measured.
    errors: bool,
    scene: Scene,
}

/// All scenes as TOML. Errors are measured on the scenes `chosen`, and with `quick` only on those of them whose steps are timed.
///
/// # Errors
/// A scene that is refused.
pub fn text(chosen: &[ComparisonScene], quick: bool) -> Result<String, Failure> {
    let entry = |case: &ComparisonScene| {
        let load = LOADS.iter().find(|load| load.0 == case.name);
        let timed_steps = load.map_or(0, |load| (load.2 / H).round() as usize);
        let errors = chosen.iter().any(|chosen| chosen.name == case.name) && (timed_steps > 0 || !quick);
        Ok(Entry { name: case.name, samples: samples(case.question), timed_steps, errors, scene: scene(case.name)? })
    };
    let file = ScenesFile { scenes: CASES.iter().map(entry).collect::<Result<_, Failure>>()? };
    let text = toml::to_string(&file).map_err(|error| Failure::new(Exit::Fault, error.to_string()))?;
    Ok(format!("{HEAD}{text}"))
}

/// Number of rows of a trace after the first that the errors need; 0: one for each step.
fn samples(question: Question) -> usize {
    match question {
        Question::Flight => 100,
        Question::Slide | Question::Descend | Question::Stick | Question::Stand => 2,
        Question::Drop | Question::Rock | Question::Wheel => 0,
        Question::Turn | Question::Roll => 1,
    }
}

/// A comparison scene, resolved.
///
/// # Errors
/// A scene that is refused.
pub fn scene(name: &str) -> Result<Scene, Failure> {
    let mut scene = cases::scene(name, Combination { law: LAW, method: METHOD }, H, &[])?;
    let plant = Plant::new(&scene)?;
    let pose = Pose::of(plant.model(), plant.state());
    let base = &pose.links[plant.model().base_link];
    scene.initial.clearance = None;
    scene.initial.position = plant.truth().base_position;
    for body in &mut scene.bodies {
        body.inertia = Some(body.moments());
    }
    turn_axes(&mut scene);
    if let Some(body) = scene.bodies.iter().find(|body| body.joint.is_none()) {
        let (name, com) = (body.name.clone(), body.com);
        let arm = base.rotation * Vector3::from(com);
        let spin = Vector3::from(scene.initial.angular_velocity);
        scene.initial.position = (Vector3::from(scene.initial.position) + arm).into();
        scene.initial.velocity = (Vector3::from(scene.initial.velocity) + spin.cross(&arm)).into();
        move_origin(&mut scene, &name, com);
    }
    Ok(scene)
}

/// Turns round the joint axes that point along a negative axis, with angles, rates and rest positions.
fn turn_axes(scene: &mut Scene) {
    let initial = &mut scene.initial;
    for (k, joint) in scene.bodies.iter_mut().filter_map(|body| body.joint.as_mut()).enumerate() {
        joint.damping += scene.plant.joint_damping;
        if joint.axis.iter().sum::<f64>() > 0.0 {
            continue;
        }
        let turned = |value: &mut f64| *value = 0.0 - *value; // never -0
        joint.axis.iter_mut().chain([&mut joint.rest]).for_each(turned);
        initial.joints.get_mut(k).into_iter().chain(initial.joint_rates.get_mut(k)).for_each(turned);
    }
    scene.plant.joint_damping = 0.0;
}

/// Moves the origin of a body to a point of it.
fn move_origin(scene: &mut Scene, name: &str, to: [f64; 3]) {
    let less = |place: &mut [f64; 3]| place.iter_mut().zip(to).for_each(|(place, to)| *place -= to);
    for body in &mut scene.bodies {
        if let Some(joint) = body.joint.as_mut().filter(|joint| joint.parent == name) {
            less(&mut joint.at);
        }
        if body.name == name {
            less(&mut body.com);
            body.contacts.iter_mut().for_each(less);
            body.spheres.iter_mut().for_each(|sphere| less(&mut sphere.at));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The robot's mechanics do not depend on the form: energy, momentum and centre of mass are those of the built-in scene.
    #[test]
    fn a_resolved_scene_is_the_same_robot_in_the_same_state() {
        for case in CASES {
            let given = cases::scene(case.name, Combination { law: LAW, method: METHOD }, H, &[]).expect("a scene");
            let [given, resolved] = [given, scene(case.name).expect("resolved")].map(|scene| {
                let plant = Plant::new(&scene).expect("a plant");
                let pose = Pose::of(plant.model(), plant.state());
                plant::kinematics::totals(plant.model(), plant.state(), &pose)
            });
            let near = |a: f64, b: f64| (a - b).abs() < 1e-14 * (1.0 + a.abs());
            let vectors =
                [(given.com, resolved.com), (given.linear, resolved.linear), (given.angular, resolved.angular)];
            assert!(vectors.iter().all(|(a, b)| (0..3).all(|i| near(a[i], b[i]))), "{}: {vectors:?}", case.name);
            assert!(near(given.mass, resolved.mass) && near(given.kinetic, resolved.kinetic), "{}", case.name);
        }
    }

    #[test]
    fn nothing_is_left_to_be_derived() {
        for case in CASES {
            let scene = scene(case.name).expect("resolved");
            assert!(scene.initial.clearance.is_none() && scene.bodies.iter().all(|body| body.inertia.is_some()));
            let joints = || scene.bodies.iter().filter_map(|body| body.joint.as_ref());
            assert!(joints().all(|joint| joint.axis.iter().all(|part| part.is_sign_positive())), "{}", case.name);
            let base = scene.bodies.iter().find(|body| body.joint.is_none()).expect("a base");
            assert_eq!(base.com, [0.0; 3], "{}", case.name);
        }
    }
}
