//! Claims about recorders: in lockstep they receive every truth, and their number is limited.

use crate::contract;
use biped_messages::port::{Contract, Pace, PlantPort, RecorderPort};
use biped_messages::session::Session;
use biped_messages::wire::{Stamp, Truth};
use std::time::{Duration, Instant};

#[test]
fn a_recorder_receives_every_truth_in_order_even_after_the_plant_has_ended() {
    const COUNT: u64 = 20_000; // several times the buffer
    let session = Session::unique();
    let mut recorder = RecorderPort::open(&session, &contract()).expect("recorder");
    std::thread::scope(|scope| {
        let plant = scope.spawn(|| {
            let port = PlantPort::open(&session, &contract()).expect("plant");
            for seq in 1..=COUNT {
                port.record(Truth { stamp: Stamp { seq, ..Stamp::default() }, ..Truth::default() }).expect("truth");
            }
            port.unrecorded()
        });
        let (mut seen, mut idle) = (0, Instant::now());
        while seen < COUNT && idle.elapsed() < Duration::from_secs(20) {
            match recorder.read().expect("recorder") {
                Some(truth) => {
                    seen += 1;
                    assert_eq!(truth.stamp.seq, seen);
                    idle = Instant::now();
                }
                None => std::thread::sleep(Duration::from_millis(2)),
            }
            if seen == COUNT / 2 {
                std::thread::sleep(Duration::from_millis(200)); // long enough for the plant to have to wait
                assert!(!plant.is_finished(), "the plant ran ahead of a full buffer");
            }
        }
        assert_eq!(seen, COUNT);
        assert_eq!(plant.join().expect("plant"), 0);
    });
}

#[test]
fn at_its_end_a_plant_waits_for_a_recorder_that_has_not_begun_to_read() {
    let session = Session::unique();
    let mut recorder = RecorderPort::open(&session, &contract()).expect("recorder");
    std::thread::scope(|scope| {
        let plant = scope.spawn(|| {
            let port = PlantPort::open(&session, &contract()).expect("plant");
            (0..10).for_each(|_| port.record(Truth::default()).expect("truth"));
            port.finish();
        });
        std::thread::sleep(Duration::from_millis(300)); // long enough on a busy machine
        assert!(!plant.is_finished(), "the plant ended before the recorder had read");
        let mut seen = 0;
        while recorder.read().expect("recorder").is_some() {
            seen += 1;
        }
        assert_eq!(seen, 10);
    });
}

#[test]
fn a_recorder_that_begins_to_read_late_receives_every_truth() {
    const COUNT: u64 = 10_000; // more than the buffer holds
    let session = Session::unique();
    let mut recorder = RecorderPort::open(&session, &contract()).expect("recorder");
    std::thread::scope(|scope| {
        let plant = scope.spawn(|| {
            let port = PlantPort::open(&session, &contract()).expect("plant");
            (1..=COUNT).for_each(|_| port.record(Truth::default()).expect("truth"));
            port.finish();
        });
        std::thread::sleep(Duration::from_millis(300));
        let (mut seen, start) = (0, Instant::now());
        while seen < COUNT && start.elapsed() < Duration::from_secs(20) {
            seen += u64::from(recorder.read().expect("recorder").is_some());
        }
        assert_eq!(seen, COUNT);
        plant.join().expect("plant");
    });
}

#[test]
fn in_real_time_a_full_buffer_loses_truth_and_the_plant_never_waits() {
    let session = Session::unique();
    let contract = Contract { pace: Pace::RealTime, ..contract() };
    let mut recorder = RecorderPort::open(&session, &contract).expect("recorder");
    let plant = PlantPort::open(&session, &contract).expect("plant");
    assert!(recorder.read().expect("recorder").is_none()); // connects
    let count = 10_000;
    (0..count).for_each(|_| plant.record(Truth::default()).expect("truth"));
    let mut got = 0;
    while recorder.read().expect("recorder").is_some() {
        got += 1;
    }
    assert!(plant.unrecorded() > 0);
    assert_eq!(got + plant.unrecorded(), count);
}

#[test]
fn one_observer_too_many_is_refused_with_a_sentence_until_another_leaves() {
    let session = Session::unique();
    let _plant = PlantPort::open(&session, &contract()).expect("plant");
    let mut observers = vec![];
    let refusal = loop {
        match RecorderPort::attach(&session) {
            Ok(port) => observers.push(port),
            Err(error) => break error,
        }
    };
    assert_eq!(observers.len(), 3, "the launcher, a page and a terminal");
    let sentence = format!("session `{}` has as many observers as it allows", session.name());
    assert!(refusal.to_string().starts_with(&sentence), "{refusal}");
    drop(observers.pop());
    RecorderPort::attach(&session).expect("there is room again");
}
