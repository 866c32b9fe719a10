//! Claims about sessions: their names, and the files of running, dead and killed processes.

use crate::contract;
use biped_messages::port::{ControllerPort, PlantPort, PortError};
use biped_messages::session::Session;
use std::time::{Duration, Instant};

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

/// The same where the creator is killed while the other process is opening its port: it ends with an error, and leaves its files to the
/// last member.
#[test]
fn a_segment_that_stays_without_a_size_while_a_port_is_opened_does_not_block_it() {
    const JOINED: Duration = Duration::from_millis(170); // a process that joins has by then removed those that it found
    let session = Session::unique();
    let plant = PlantPort::open(&session, &contract()).expect("plant");
    let topic = |path: &std::path::PathBuf| path.extension().is_some_and(|end| end == "dynamic");
    let segments: Vec<_> = session.shm_files().into_iter().filter(topic).collect();
    segments.iter().for_each(|segment| std::fs::remove_file(segment).expect("our own file"));
    let (done, ended) = std::sync::mpsc::channel();
    let other = session.clone();
    std::thread::spawn(move || done.send(ControllerPort::open(&other, &contract()).map(|_| ())));
    let start = Instant::now();
    while start.elapsed() < JOINED {
        for segment in &segments {
            let mut write_only = std::fs::File::options();
            std::os::unix::fs::OpenOptionsExt::mode(write_only.write(true).create_new(true), 0o200);
            let _ = write_only.open(segment); // it may be there still
        }
    }
    let opened = ended.recv_timeout(Duration::from_secs(20)).expect("opening ends");
    assert!(matches!(opened, Err(PortError::SharedMemory(_) | PortError::Foreign { .. })), "{opened:?}");
    drop(plant);
    assert_eq!(session.shm_files(), Vec::<std::path::PathBuf>::new());
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
