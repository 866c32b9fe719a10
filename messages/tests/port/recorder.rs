//! Claims about recorders: in lockstep they receive every truth, and their number is limited.

use crate::contract;
use biped_messages::port::{Contract, Pace, PlantPort, RecorderPort};
use biped_messages::session::Session;
use biped_messages::wire::{Stamp, Truth};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
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

/// Time that a plant takes to end after it is asked to stop, while its recorder does not read, like a launcher that was killed. `begins`
/// says whether the recorder has begun to read before.
fn time_to_stop(begins: bool, plant: impl Fn(&PlantPort) + Sync) -> Duration {
    let session = Session::unique();
    let mut recorder = RecorderPort::open(&session, &contract()).expect("recorder");
    if begins {
        assert!(recorder.read().expect("recorder").is_none());
    }
    let stop = Arc::new(AtomicBool::new(false));
    let port = || PlantPort::open_with_stop(&session, &contract(), stop.clone()).expect("plant");
    std::thread::scope(|scope| {
        let plant = scope.spawn(|| plant(&port()));
        std::thread::sleep(Duration::from_millis(300)); // long enough to fill the buffer on a busy machine
        assert!(!plant.is_finished(), "the plant did not wait for its recorder");
        let asked = Instant::now();
        stop.store(true, Relaxed);
        plant.join().expect("plant");
        asked.elapsed()
    })
}

/// A launcher that is killed leaves a full buffer. Without the stop flag the plant would wait for it for 3 s.
#[test]
fn a_plant_that_is_asked_to_stop_does_not_wait_for_a_recorder_that_does_not_read() {
    const LIMIT: Duration = Duration::from_secs(2);
    let fill = |port: &PlantPort| (0..10_000).for_each(|_| port.record(Truth::default()).expect("truth"));
    let finish = |port: &PlantPort| port.finish();
    for (name, took) in [
        ("a full buffer", time_to_stop(true, fill)),
        ("a recorder that never begins", time_to_stop(false, fill)),
        ("the end of a run", time_to_stop(false, finish)),
    ] {
        assert!(took < LIMIT, "{name}: the plant ended after {took:?}");
    }
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
