//! Claims about the connection between two processes. Here two threads use one end each.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod bells;
mod recorder;
mod sessions;

use biped_messages::port::{Contract, ControllerPort, Pace, PlantPort, PortError, Waiting};
use biped_messages::scene::Scene;
use biped_messages::session::Session;
use biped_messages::wire::{Command, Sensors, Stamp};
use std::time::{Duration, Instant};

fn contract() -> Contract {
    Contract::of(&Scene::default(), Pace::Lockstep)
}

/// Epochs of a plant and a controller that ring and hear bells.
const EPOCHS: [u64; 2] = [3, 4];
/// Epochs of programs that do not: a bell has no signature of the epoch 0.
const WITHOUT_BELLS: [u64; 2] = [0; 2];

fn sensors(seq: u64, epoch: u64) -> Sensors {
    Sensors { stamp: Stamp { seq, epoch, ..Stamp::default() }, ..Sensors::default() }
}

/// Answers sensors until the last ones. Returns their number.
fn answer(session: &Session, waiting: Waiting, epoch: u64) -> u64 {
    let mut port = ControllerPort::open(session, &contract()).expect("controller").waiting(waiting);
    let mut answered = 0;
    loop {
        let Some(sensors) = port.wait().expect("waiting") else { continue };
        if sensors.last != 0 {
            return answered;
        }
        answered += 1;
        let stamp = Stamp { ack: sensors.stamp.seq, epoch, ..Stamp::default() };
        port.send(Command { stamp, ..Command::default() }).expect("answering");
    }
}

/// Sends sensors and waits for their answer.
fn ask(port: &mut PlantPort, seq: u64, epoch: u64) -> Result<(), PortError> {
    port.send(sensors(seq, epoch))?;
    let start = Instant::now();
    loop {
        match port.wait()? {
            Some(command) if command.stamp.ack == seq => return Ok(()),
            _ => assert!(start.elapsed() < Duration::from_secs(20), "no answer to {seq}"),
        }
    }
}

/// Checks that each of `rounds` messages of sensors gets its answer.
fn all_sensors_are_answered(rounds: u64, [asking, answering]: [Waiting; 2], [plant, controller]: [u64; 2]) {
    let session = Session::unique();
    std::thread::scope(|scope| {
        let other = scope.spawn(|| answer(&session, answering, controller));
        let mut port = PlantPort::open(&session, &contract()).expect("plant").waiting(asking);
        (1..=rounds).try_for_each(|seq| ask(&mut port, seq, plant)).expect("answers");
        port.send(Sensors { last: 1, ..sensors(rounds + 1, plant) }).expect("sending");
        drop(port); // The goodbye can still be read after its sender has ended.
        assert_eq!(other.join().expect("controller"), rounds);
    });
    assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
}

#[test]
fn all_sensors_are_answered_for_each_way_of_waiting_and_no_file_remains() {
    for waiting in [Waiting::Spin, Waiting::Hybrid, Waiting::Event] {
        all_sensors_are_answered(5_000, [waiting; 2], WITHOUT_BELLS);
        all_sensors_are_answered(5_000, [waiting; 2], EPOCHS);
    }
}

#[test]
fn two_ends_that_wait_differently_can_exchange_messages() {
    for epochs in [WITHOUT_BELLS, EPOCHS] {
        all_sensors_are_answered(50, [Waiting::Spin, Waiting::Event], epochs);
        all_sensors_are_answered(50, [Waiting::Event, Waiting::Spin], epochs);
    }
}

#[test]
fn a_controller_that_joins_late_gets_the_last_sensors() {
    let session = Session::unique();
    let mut plant = PlantPort::open(&session, &contract()).expect("plant");
    for restart in 1..=3 {
        plant.send(sensors(restart, 3)).expect("sending");
        let mut controller = ControllerPort::open(&session, &contract()).expect("controller");
        assert!(plant.wait().expect("waiting").is_none());
        let got = controller.wait().expect("waiting").expect("the last sensors");
        assert_eq!(got.stamp.seq, restart);
    }
}

#[test]
fn a_different_contract_is_refused_with_both_values() {
    let session = Session::unique();
    let _plant = PlantPort::open(&session, &contract()).expect("plant");
    let others = [
        ("wire schema", Contract { schema: contract().schema + 1, ..contract() }),
        ("model", Contract { model: 0, ..contract() }),
        ("rate", Contract { rate: 500.0, ..contract() }),
        ("dt", Contract { dt: 1e-4, ..contract() }),
        ("pace", Contract { pace: Pace::RealTime, ..contract() }),
    ];
    for (part, other) in others {
        match ControllerPort::open(&session, &other).expect_err(part) {
            PortError::Incompatible { what, theirs, ours, .. } => {
                assert_eq!(what, part);
                assert_ne!(theirs, ours);
            }
            error => panic!("{part}: {error}"),
        }
    }
    ControllerPort::open(&session, &contract()).expect("the right contract is accepted afterwards");
}

#[test]
fn the_model_hash_depends_on_plant_and_bodies_only() {
    let scene = Scene::default();
    let model = |change: fn(&mut Scene)| {
        let mut scene = scene.clone();
        change(&mut scene);
        Contract::of(&scene, Pace::Lockstep).model
    };
    let same = model(|_| ());
    assert_eq!(model(|scene| scene.duration = 3.0), same);
    assert_ne!(model(|scene| scene.plant.friction = 0.3), same);
    assert_ne!(model(|scene| scene.bodies[0].mass += 1e-12), same);
}

#[test]
fn a_second_plant_or_controller_is_refused_until_the_first_has_left() {
    let session = Session::unique();
    let plant = PlantPort::open(&session, &contract()).expect("plant");
    let controller = ControllerPort::open(&session, &contract()).expect("controller");
    let taken = |result: Result<(), PortError>, who: &str| match result {
        Err(PortError::Taken { role, .. }) => assert_eq!(role, who),
        other => panic!("{who}: {other:?}"),
    };
    taken(PlantPort::open(&session, &contract()).map(drop), "plant");
    taken(ControllerPort::open(&session, &contract()).map(drop), "controller");
    drop((plant, controller));
    PlantPort::open(&session, &contract()).expect("the session has no plant any more");
}

#[test]
fn the_transport_version_is_the_pinned_one() {
    let (name, version) = biped_messages::port::TRANSPORT.split_once(' ').expect("a name and a version");
    assert!(include_str!("../../Cargo.toml").contains(&format!("{name} = \"={version}\"")));
}
