//! Claims about the connection between two processes. Here two threads use one end each.

#![expect(clippy::expect_used, reason = "a test may panic")]

use biped_messages::port::{Contract, ControllerPort, Pace, PlantPort, PortError, RecorderPort, Waiting};
use biped_messages::scene::Scene;
use biped_messages::session::Session;
use biped_messages::wire::{Command, Sensors, Stamp, Truth};
use nix::time::ClockId;
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

/// Processor time of this thread so far.
fn processor_time() -> Duration {
    ClockId::CLOCK_THREAD_CPUTIME_ID.now().expect("a clock").into()
}

/// Answers sensors until the last ones. Returns their number, and the processor time of that.
fn answer(session: &Session, waiting: Waiting, epoch: u64) -> (u64, Duration) {
    let mut port = ControllerPort::open(session, &contract()).expect("controller").waiting(waiting);
    let (mut answered, start) = (0, processor_time());
    loop {
        let Some(sensors) = port.wait().expect("waiting") else { continue };
        if sensors.last != 0 {
            return (answered, processor_time() - start);
        }
        answered += 1;
        let stamp = Stamp { ack: sensors.stamp.seq, epoch, ..Stamp::default() };
        port.send(Command { stamp, ..Command::default() }).expect("answering");
    }
}

fn ask(port: &mut PlantPort, seq: u64, epoch: u64) {
    port.send(sensors(seq, epoch)).expect("sending");
    let start = Instant::now();
    loop {
        match port.wait().expect("waiting") {
            Some(command) if command.stamp.ack == seq => return,
            _ => assert!(start.elapsed() < Duration::from_secs(20), "no answer to {seq}"),
        }
    }
}

/// Checks that each of `rounds` messages of sensors gets its answer. Returns the processor time of both sides.
fn all_sensors_are_answered(rounds: u64, [asking, answering]: [Waiting; 2], [plant, controller]: [u64; 2]) -> Duration {
    let session = Session::unique();
    let total = std::thread::scope(|scope| {
        let other = scope.spawn(|| answer(&session, answering, controller));
        let mut port = PlantPort::open(&session, &contract()).expect("plant").waiting(asking);
        let start = processor_time();
        (1..=rounds).for_each(|seq| ask(&mut port, seq, plant));
        let own = processor_time() - start;
        port.send(Sensors { last: 1, ..sensors(rounds + 1, plant) }).expect("sending");
        drop(port); // The goodbye can still be read after its sender has ended.
        let (answered, others) = other.join().expect("controller");
        assert_eq!(answered, rounds);
        own + others
    });
    assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
    total
}

#[test]
fn all_sensors_are_answered_for_each_way_of_waiting_and_no_file_remains() {
    for waiting in [Waiting::Spin, Waiting::Hybrid, Waiting::Event] {
        all_sensors_are_answered(5_000, [waiting; 2], WITHOUT_BELLS);
        all_sensors_are_answered(5_000, [waiting; 2], EPOCHS);
    }
}

/// A side falls back to the event if the other one does not sign the bell.
#[test]
fn a_program_with_bells_and_one_without_can_exchange_messages() {
    let [plant, controller] = EPOCHS;
    all_sensors_are_answered(1_000, [Waiting::Event; 2], [plant, 0]);
    all_sensors_are_answered(1_000, [Waiting::Event; 2], [0, controller]);
}

/// The reason for the bell. The event takes eight system calls for each message, the bell two.
#[test]
fn the_bell_takes_less_processor_time_than_the_event() {
    let taken = [WITHOUT_BELLS, EPOCHS];
    let turns = (0..5).map(|_| taken.map(|epochs| all_sensors_are_answered(3_000, [Waiting::Event; 2], epochs)));
    let [event, bell] = turns.reduce(|[a, b], [c, d]| [a.min(c), b.min(d)]).expect("five turns");
    println!("event {event:?}, bell {bell:?}: {:.2} times", bell.as_secs_f64() / event.as_secs_f64());
    assert!(bell < event.mul_f64(0.85), "{bell:?} beside {event:?}");
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

#[test]
fn sessions_do_not_affect_each_other() {
    let (one, other) = (Session::unique(), Session::unique());
    let first = PlantPort::open(&one, &contract()).expect("plant");
    let _other = PlantPort::open(&other, &contract()).expect("plant");
    assert_eq!(one.members(), [std::process::id()]);
    let count = other.shm_files().len();
    one.remove_files();
    assert!(count > 0 && !one.shm_files().is_empty(), "the session is running");
    drop(first);
    assert!(one.shm_files().is_empty());
    assert_eq!(other.shm_files().len(), count);
}

#[test]
fn the_first_member_of_a_session_removes_the_files_of_stale_sessions() {
    let (dead, alive) = (Session::unique(), Session::unique());
    let port = PlantPort::open(&dead, &contract()).expect("plant");
    let lock_file =
        dead.shm_files().into_iter().find(|path| path.to_string_lossy().ends_with("members")).expect("a lock file");
    drop(port);
    let segment = std::path::PathBuf::from(lock_file.to_string_lossy().replace("members", "abandoned"));
    std::fs::write(&lock_file, dead.name()).expect("a lock file without a lock");
    std::fs::write(&segment, "").expect("an empty segment");
    assert!(!dead.is_running() && dead.shm_files().contains(&segment));
    let _port = PlantPort::open(&alive, &contract()).expect("plant");
    assert_eq!(dead.shm_files(), Vec::<std::path::PathBuf>::new());
    assert!(alive.is_running());
}

/// As root, iceoryx2 waits for ever for a segment whose creator was killed before the segment had a size.
#[test]
fn a_segment_without_a_size_does_not_block_another_process() {
    let session = Session::unique();
    let plant = PlantPort::open(&session, &contract()).expect("plant");
    let controller = ControllerPort::open(&session, &contract()).expect("controller");
    let connection = |path: &std::path::PathBuf| path.to_string_lossy().ends_with(".connection");
    let model = session.shm_files().into_iter().find(connection).expect("a connection");
    let incomplete = model.with_file_name(model.to_string_lossy().replace(".connection", "1.connection"));
    std::fs::write(&incomplete, "").expect("a segment");
    std::fs::set_permissions(&incomplete, std::os::unix::fs::PermissionsExt::from_mode(0o200)).expect("our own file");
    drop(controller);
    ControllerPort::open(&session, &contract()).expect("another controller");
    assert!(!incomplete.exists());
    drop(plant);
    assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
}

#[test]
fn the_transport_version_is_the_pinned_one() {
    let (name, version) = biped_messages::port::TRANSPORT.split_once(' ').expect("a name and a version");
    assert!(include_str!("../Cargo.toml").contains(&format!("{name} = \"={version}\"")));
}

#[test]
fn the_name_of_a_session_must_be_a_valid_file_name() {
    for bad in ["", "a/b", "..", "a b", "an-awfully-long-name-for-just-one-session"] {
        assert!(matches!(Session::named(bad), Err(PortError::SessionName { .. })), "{bad}");
    }
    let longest = Session::named("the-longest-name-of-32-characters").expect_err("33 characters are too many");
    assert!(longest.to_string().contains("32"));
    let longest = Session::named("the-longest-name-of-32-character").expect("a good name");
    ControllerPort::open(&longest, &contract()).expect("a long name fits everywhere");
    assert!(longest.shm_files().is_empty());
}
