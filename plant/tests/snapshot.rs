//! Claim: a run that returns to a snapshot, or continues from it in another plant, has the same bits as without that detour.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_plant::{PlantError, Simulation};
use controller::Controller;
use messages::load::{SCENES, load};
use messages::scene::Scene;
use messages::wire::{Command, Stamp, Stamped};

fn scene(name: &str, settings: &[&str]) -> Scene {
    let settings: Vec<String> = settings.iter().map(|setting| setting.to_string()).collect();
    load(name, &settings, SCENES).expect("a good scene")
}

/// A plant and the controller of its scene.
struct DrivenPlant(Simulation, Option<Controller>);

impl DrivenPlant {
    fn new(scene: &Scene) -> DrivenPlant {
        let controller = scene.controller.as_ref().map(|_| Controller::new(scene).expect("a good scene"));
        DrivenPlant(Simulation::new(scene, 1, 1).expect("a good scene"), controller)
    }

    /// Runs for some control periods, or up to an error. Returns the hash of all states.
    fn advance(&mut self, periods: usize) -> Result<u64, PlantError> {
        for _ in 0..periods {
            let sensors = self.0.sensors();
            if let Some(controller) = &mut self.1 {
                let torques = controller.tick(&sensors.encoders).expect("it stays up");
                let stamp = Stamp { ack: sensors.stamp.seq, ..sensors.stamp };
                self.0.receive(&Command { stamp, torques, ..Command::default() }.sealed());
            }
            self.0.advance()?;
        }
        Ok(self.0.truth().hash)
    }
}

/// Compares the straight run with the detour after `before` periods, over the `after` periods that follow.
fn repeats(name: &str, settings: &[&str], before: usize, after: usize) {
    let scene = scene(name, settings);
    let mut run = DrivenPlant::new(&scene);
    let _ = run.0.push(0, [0.3, 0.1, 0.0], 0.5); // still acts when the snapshot is taken
    run.advance(before).expect("a run without errors up to the snapshot");
    let (snapshot, controller) = (run.0.snapshot(), run.1.clone());
    let straight = run.advance(after);

    run.1 = controller.clone();
    run.0.restore(&snapshot);
    run.0.prepare(); // as the process does while it waits
    assert_eq!(run.advance(after), straight, "{name} {settings:?}: the same plant");

    let mut other = DrivenPlant::new(&scene);
    other.advance(before / 3).expect("as above"); // a workspace with other contents
    other.1 = controller;
    other.0.restore(&snapshot);
    assert_eq!(other.advance(after), straight, "{name} {settings:?}: another plant");
}

#[test]
fn walking_continues_with_the_same_bits_in_every_phase() {
    for before in [1, 2, 700, 1111, 1234, 1500] {
        repeats("walk", &["duration=3"], before, 300);
    }
}

#[test]
fn every_method_and_law_continues_with_the_same_bits() {
    for name in ["slide", "incline", "rock", "ball", "drop", "wheel"] {
        repeats(name, &[], 150, 200);
    }
    let methods = ["ExplicitEuler", "SemiImplicitEuler", "MoreauJean", "MidpointMoreau", "MidpointContact", "Rk4"];
    let others = ["Rk4Impact", "ImplicitMidpoint", "StepDoubling", "EventDriven"];
    for method in methods.into_iter().chain(others) {
        repeats("slide30", &[&format!("plant.method={method}")], 130, 100);
    }
    for law in ["Aligned", "Cone", "EnergyQp", "SpringDamper", "FixedPoint"] {
        repeats("slide30", &["plant.method=SemiImplicitEuler", &format!("plant.law={law}")], 130, 100);
    }
}

#[test]
fn commands_under_way_and_random_numbers_are_part_of_a_snapshot() {
    let late = ["duration=2", "link.delay_ms=1.5", "link.jitter_ms=2", "link.loss=0.1", "plant.stale_probability=0.2"];
    repeats("stand", &late, 300, 300);
}
