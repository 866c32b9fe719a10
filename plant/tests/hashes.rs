//! Claim: the first second of every built-in scene has the published bits in any build, on one thread or several, in every run.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_plant::Simulation;
use controller::Controller;
use messages::load::built_in;
use messages::scene::Scene;
use messages::wire::{Command, Stamp, Stamped};

/// Published names and hashes of the first second.
fn published() -> Vec<(String, String)> {
    let table = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../messages/scenes/hashes.txt"))
        .expect("the table");
    let words = |line: &str| line.split_whitespace().map(String::from).take(2).collect::<Vec<_>>();
    let rows = table.lines().skip(1).map(words);
    rows.map(|row| <[String; 2]>::try_from(row).expect("name and hash").into()).collect()
}

fn scene(name: &str) -> Scene {
    let mut scene = built_in(name).expect("a good scene");
    scene.duration = scene.duration.min(1.0);
    scene
}

/// Hash of the states of the first second, or up to the error that ends the run.
fn hash(name: &str) -> String {
    let scene = scene(name);
    let mut simulation = Simulation::new(&scene, 1, 1).expect("a good scene");
    let mut controller = scene.controller.as_ref().map(|_| Controller::new(&scene).expect("a good scene"));
    let mut hash = simulation.truth().hash;
    while simulation.sensors().last == 0 {
        let sensors = simulation.sensors();
        if let Some(controller) = &mut controller {
            let torques = controller.tick(&sensors.encoders).expect("it stays up");
            let stamp = Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
            simulation.receive(&Command { stamp, torques, ..Command::default() }.sealed());
        }
        if simulation.advance().is_err() {
            break; // scene gimbal ends at its singular pitch
        }
        hash = simulation.truth().hash;
    }
    format!("{hash:016x}")
}

fn agrees((name, published): &(String, String)) {
    assert_eq!(&hash(name), published, "{name}; launch/laboratory/src/hashes.rs says how to renew them");
}

#[test]
fn the_first_second_has_the_published_bits_in_every_run() {
    let published = published();
    assert!(published.len() > 30, "every scene has its row");
    published.iter().for_each(agrees);
    published.iter().rev().step_by(4).for_each(agrees);
}

#[test]
fn several_threads_give_the_same_bits() {
    let (published, threads) = (published(), 4);
    std::thread::scope(|scope| {
        for first in 0..threads {
            scope.spawn({
                let published = &published;
                move || published.iter().skip(first).step_by(threads).for_each(agrees)
            });
        }
    });
}
