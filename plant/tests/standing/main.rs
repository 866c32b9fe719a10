//! Claims about standing feet, solved as six equations per foot: they change the time of a step, but no result.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod airborne;
mod edge;
mod frictionless;
mod tilted;

use biped_plant::Plant;
use biped_plant::kinematics::{self, Pose, Totals};
use controller::Controller;
use messages::load::{SCENES, load};
use messages::scene::Scene;
use messages::wire::Torques;

fn scene(name: &str, settings: &[&str]) -> Scene {
    let settings: Vec<_> = settings.iter().map(ToString::to_string).collect();
    load(name, &settings, SCENES).expect("a scene")
}

fn totals(plant: &Plant) -> Totals {
    let pose = Pose::of(plant.model(), plant.state());
    kinematics::totals(plant.model(), plant.state(), &pose)
}

/// Runs a scene with and without standing feet. Returns the greatest difference of the states, the number of steps with standing feet, and
/// both plants at the end.
fn compare(scene: &Scene, steps: usize) -> (f64, usize, [Plant; 2]) {
    let mut plants = [Plant::new(scene).expect("a plant"), Plant::new(scene).expect("a plant").without_standing_feet()];
    let (mut worst, mut held) = (0.0_f64, 0);
    for _ in 0..steps {
        for plant in &mut plants {
            plant.advance(&Torques::default()).expect("a step");
        }
        let [ours, theirs] = plants.each_ref().map(Plant::state);
        let pairs = ours.x.iter().zip(&theirs.x).chain(ours.xdot.iter().zip(&theirs.xdot));
        worst = pairs.fold(worst, |worst, (a, b)| worst.max((a - b).abs()));
        held += usize::from(plants[0].problem().delassus.is_empty());
        assert!(!plants[1].problem().delassus.is_empty());
    }
    (worst, held, plants)
}

#[test]
fn standing_feet_move_as_contact_by_contact() {
    for name in ["stand0", "stand10"] {
        let (worst, held, plants) = compare(&scene(name, &[]), 6000);
        println!("{name}: states differ by {worst:.1e}, {held} of 6000 steps held");
        assert!(worst < 1e-9, "{name}: {worst}");
        assert!(held > 1000, "{name}: only {held} steps"); // on the slope the feet tip a little before they rest
        let [ours, theirs] = plants.each_ref().map(Plant::truth);
        let weight = |force: &[f64]| force.iter().skip(2).step_by(3).sum::<f64>();
        let difference = (weight(&ours.contact_force) - weight(&theirs.contact_force)).abs();
        assert!(difference < 1e-6, "{name}: the weights differ by {difference} N");
    }
}

#[test]
fn a_foot_on_an_edge_or_a_point_stands_as_contact_by_contact() {
    let sole = [0.0, 0.0, -0.05];
    let edge = |x: f64, y: f64| vec![[x, y, sole[2]], [-x, -y, sole[2]]];
    for (name, contacts) in [("point", vec![sole]), ("edge", edge(0.1, 0.0)), ("diagonal", edge(0.1, 0.05))] {
        let mut scene = scene("stand0", &[]);
        let foot = scene.bodies.last_mut().expect("a robot");
        assert_eq!(foot.contacts.len(), 4);
        foot.contacts = contacts;
        let (worst, held, _) = compare(&scene, 3000);
        println!("{name}: states differ by {worst:.1e}, {held} of 3000 steps held");
        assert!(worst < 1e-9, "{name}: {worst}");
        assert!(held > 1000, "{name}: only {held} steps");
    }
}

#[test]
fn the_load_of_a_standing_foot_is_linear_over_its_sole() {
    let (_, _, [plant, _]) = compare(&scene("stand0", &[]), 2000);
    let force = plant.truth().contact_force;
    for foot in force.chunks_exact(12).take(2) {
        let load = |point: usize| foot[3 * point + 2];
        let bent = load(0) + load(3) - load(1) - load(2); // contact points in the order ++, +-, -+, --
        assert!(bent.abs() < 1e-9, "{foot:?}");
        assert!(load(0) > 0.0);
    }
}

/// The legs hold the feet apart along a direction in which no impulse moves them, so any internal force would be a solution. The least one
/// is zero.
#[test]
fn standing_feet_have_no_internal_forces_without_effect() {
    let scene = scene("walk", &[]);
    let (mut plant, mut controller) =
        (Plant::new(&scene).expect("a plant"), Controller::new(&scene).expect("a controller"));
    let (mut count, mut sum) = (0, 0.0);
    for _ in 0..2000 {
        let torques = controller.tick(&plant.encoders()).expect("it walks");
        plant.advance(&torques).expect("it walks");
        if plant.problem().contacts == 8 && plant.problem().delassus.is_empty() {
            let force = plant.truth().contact_force;
            let feet = force.chunks_exact(12).map(|foot| {
                let total = |axis: usize| foot.iter().skip(axis).step_by(3).sum::<f64>();
                if total(2) > 0.0 { total(0).hypot(total(1)) / total(2) } else { 0.0 }
            });
            count += 1;
            sum += feet.fold(0.0, f64::max);
        }
    }
    let mean = sum / f64::from(count);
    println!("on both feet for {count} ms, friction of {mean:.3} of the load in the mean");
    // with all internal forces it is .121; the rest is friction that the feet need
    assert!(count > 300 && mean < 0.08, "{mean} over {count} ms");
}

#[test]
fn a_sliding_foot_is_not_held_and_a_tipping_one_turns_about_its_edges() {
    for (name, settings, expected) in [
        ("stand10", vec!["plant.friction=0.1"], 0..100),
        ("stand0", vec!["plant.push_impulse=[0,12,0]", "plant.push_time=0", "plant.push_duration=0.1"], 200..400),
    ] {
        let (worst, held, [plant, _]) = compare(&scene(name, &settings), 400);
        println!("{name} {settings:?}: states differ by {worst:.1e}, {held} of 400 steps held");
        let moved = plant.truth().base_velocity.iter().fold(0.0, |most: f64, v| most.max(v.abs()));
        assert!(moved > 0.1, "{name}: the scene does not move, {moved} m/s");
        assert!(worst < 1e-6, "{name}: {worst}");
        assert!(expected.contains(&held), "{name}: {held} steps were held");
    }
}

#[test]
fn the_contact_problem_is_empty_in_flight() {
    for (name, method) in
        [("stand0", "SemiImplicitEuler"), ("stand0", "Rk4"), ("drop", "Rk4Impact"), ("drop", "EventDriven")]
    {
        let mut plant = Plant::new(&scene(name, &[&format!("plant.method={method}")])).expect("a plant");
        let contacts_after = |plant: &mut Plant, what: &str| {
            for _ in 0..100 {
                plant.advance(&Torques::default()).expect(what);
            }
            plant.problem().contacts
        };
        assert!(contacts_after(&mut plant, "landed") > 0, "{name}, {method}");
        assert!(plant.push(0, [0.0, 0.0, 200.0], 0.001));
        assert_eq!(contacts_after(&mut plant, "thrown"), 0, "{name}, {method}");
    }
}
