//! Claims about controllers that are started by hand: they attach to a running session by its name alone, in every language,
//! whichever side starts first. If that is not possible, the program ends with a sentence and an exit code.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use languages::{compile, python};
use messages::session::Session;
use messages::wire::{FNV_START, fnv1a};
use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

fn biped(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_biped"));
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Starts a controller of a session.
type Start<'a> = &'a dyn Fn(&Session) -> Command;

/// A plant that waits for its controller.
fn plant(session: &Session) -> Child {
    let arguments = ["plant", "stand", "--set", "duration=1", "--patience", "60", "--session", session.name()];
    biped(&arguments).spawn().expect("the program starts")
}

fn wait_until(what: &str, holds: impl Fn() -> bool) {
    let start = Instant::now();
    while !holds() {
        assert!(start.elapsed() < Duration::from_secs(60), "{what} does not hold");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn words(output: &Output) -> String {
    String::from_utf8_lossy(&output.stderr).into_owned()
}

/// Asserts that both processes exit with code 0 and leave no file. Returns what the plant says of the end of the scene.
fn ends_well(session: &Session, what: &str, plant: Child, controller: Output) -> String {
    let plant = plant.wait_with_output().expect("our own child");
    let errors = words(&controller).lines().find(|line| !line.starts_with("waiting for the ")).map(String::from);
    assert_eq!((controller.status.code(), errors), (Some(0), None), "{what}: {}", words(&controller));
    assert_eq!(plant.status.code(), Some(0), "{what}: {}", words(&plant));
    let outcome = String::from_utf8_lossy(&plant.stdout).into_owned();
    assert!(outcome.starts_with("the scene ended at 1 s: base at "), "{what}: {outcome}");
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "{what}: left in shared memory");
    outcome
}

/// Published hash.
fn first_second_of_stand() -> &'static str {
    let row = include_str!("../messages/scenes/hashes.txt").lines().find(|row| row.starts_with("stand "));
    row.and_then(|row| row.split_whitespace().nth(1)).expect("a row for stand")
}

/// A clean environment, with `BIPED_SESSION` alone.
fn named_by_environment(program: &Path, session: &Session) -> Command {
    let mut command = Command::new(program);
    command.env("BIPED_SESSION", session.name()).stdin(Stdio::null());
    command
}

#[test]
fn controllers_in_every_language_attach_by_the_name_of_the_session() {
    let c = compile("cc", "-std=c11", "controller/foreign/c/stand.c");
    let by_name = |session: &Session| biped(&["controller", "--session", session.name()]);
    let of_python = |session: &Session| {
        let mut command = Command::new(python());
        command.args(["controller/foreign/python/stand.py", "--session", session.name()]);
        command
    };
    let of_c = |session: &Session| named_by_environment(&c, session);
    let ours = |session: &Session| {
        let mut command = named_by_environment(Path::new(env!("CARGO_BIN_EXE_biped")), session);
        command.arg("controller");
        command
    };
    let by_shell = |session: &Session| {
        let mut command = Command::new("sh");
        let script = r#"eval "$("$0" session "$1" --wait 60)" && "$0" controller"#;
        command.args(["-c", script, env!("CARGO_BIN_EXE_biped"), session.name()]);
        command
    };
    let python_by_shell = |session: &Session| {
        let mut command = Command::new("sh");
        let script = r#"eval "$("$0" session "$1")" && "$2" controller/foreign/python/stand.py"#; // the session is there already
        command.args(["-c", script, env!("CARGO_BIN_EXE_biped"), session.name()]).arg(python());
        command
    };
    let ways: [(&str, Start); 6] = [
        ("Rust", &by_name),
        ("Python", &of_python),
        ("C", &of_c),
        ("variable", &ours),
        ("shell", &by_shell),
        ("Python by shell", &python_by_shell),
    ];
    for (what, command) in ways {
        let session = Session::unique();
        let plant = plant(&session);
        wait_until("the session is there", || what != "Python by shell" || session.environment().is_some());
        ends_well(&session, what, plant, command(&session).output().expect("it starts"));
    }
    std::fs::remove_file(c).expect("our own file");
}

#[test]
fn a_controller_may_come_before_its_plant() {
    let session = Session::unique();
    let arguments = ["controller", "--patience", "60", "--session", session.name()];
    let controller = biped(&arguments).spawn().expect("the program starts");
    std::thread::sleep(Duration::from_millis(200));
    let plant = plant(&session);
    let outcome = ends_well(&session, "first", plant, controller.wait_with_output().expect("our own child"));
    assert!(outcome.ends_with(&format!("trajectory hash {}\n", first_second_of_stand())), "{outcome}");
}

#[test]
fn controllers_in_python_answer_biped_set_without_the_package() {
    let cases: [(&str, &str, i32, &str); 3] = [
        ("walk", "0.1", 0, "set at t"),
        ("walk", "9", 2, "refuses: controller.speed = 9 m/s is out of range"),
        ("stand", "0.1", 2, "this program does not serve the request"),
    ];
    for (controller, speed, code, words) in cases {
        let session = Session::unique();
        let plant = ["plant", "walk", "--set", "duration=1000", "--patience", "60", "--session", session.name()];
        let mut plant = biped(&plant).spawn().expect("the program starts");
        let file = format!("controller/foreign/python/{controller}.py");
        let mut controller =
            Command::new(python()).args([&file, "--session", session.name()]).spawn().expect("the program starts");
        wait_until("the controller is a member", || session.members().len() == 2);
        let set = ["set", "--session", session.name(), "--speed", speed];
        let answer = std::iter::repeat_with(|| biped(&set).output().expect("it starts"))
            .find(|answer| answer.status.code() != Some(3)) // until it serves
            .expect("one answer");
        let printed = format!("{}{}", String::from_utf8_lossy(&answer.stdout), self::words(&answer));
        assert_eq!(answer.status.code(), Some(code), "{file}: {printed}");
        assert!(printed.contains(words), "{file}: {printed}");
        for child in [&mut controller, &mut plant] {
            nix::sys::signal::kill(nix::unistd::Pid::from_raw(child.id() as i32), nix::sys::signal::Signal::SIGTERM)
                .expect("alive");
            child.wait().expect("our own child");
        }
        wait_until("the session has ended", || !session.is_running());
    }
}

#[test]
fn biped_session_prints_the_contract_as_json_and_for_an_editor() {
    let session = Session::unique();
    let mut plant = plant(&session);
    let printed = |format: &str| {
        let output =
            biped(&["session", session.name(), "--wait", "30", "--format", format]).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")
    };
    let environment = printed("json");
    assert_eq!(environment["BIPED_SESSION"], session.name());
    let contract = environment["BIPED_CONTRACT"].as_str().expect("text");
    assert!(contract.contains("pace=lockstep\n") && contract.contains("rate=1000 Hz\n"), "{contract}");
    let scene: Value = serde_json::from_str(environment["BIPED_SCENE"].as_str().expect("text")).expect("JSON");
    assert_eq!(scene["duration"], 1.0, "as it runs");
    assert_eq!(environment["BIPED_PATIENCE"], "60", "that of the session, not the time to wait for its start");
    let at_once = biped(&["session", session.name(), "--format", "json"]).output().expect("it starts").stdout;
    assert_eq!(serde_json::from_slice::<Value>(&at_once).expect("JSON"), environment);
    assert_eq!(printed("vscode")["env"], environment);
    plant.kill().expect("our own child");
    plant.wait().expect("our own child");
    session.remove_files();
}

/// A program that tries to join reports that a session of this name belongs to `daemon`, the user with the number 1 on every Linux.
fn names_the_owner_of_a_session(session: &Session) {
    let hash = fnv1a(fnv1a(FNV_START, &1u32.to_le_bytes()), session.name().as_bytes()) as u32;
    let members = PathBuf::from(format!("/dev/shm/biped_{hash:08x}_members"));
    let theirs = PathBuf::from(format!("/dev/shm/members-of-{}", session.name()));
    std::fs::write(&theirs, session.name()).expect("a file in shared memory");
    if std::os::unix::fs::chown(&theirs, Some(1), Some(1)).is_err() {
        std::fs::remove_file(theirs).expect("our own file");
        return println!("NOT CHECKED: only root can make a session of another user");
    }
    std::fs::rename(theirs, &members).expect("our own file");
    let mut stand = Command::new(python());
    stand.arg("controller/foreign/python/stand.py").env("BIPED_SESSION", session.name()).env("BIPED_PATIENCE", "0");
    let view = biped(&["view", "--session", session.name()]);
    let controller = biped(&["controller", "--patience", "0.1", "--session", session.name()]);
    let sentences = [stand, view, controller, biped(&["session", session.name()])]
        .map(|mut it| words(&it.output().expect("it starts")));
    std::fs::remove_file(members).expect("our own file");
    for sentence in sentences {
        assert!(sentence.contains("belongs to user daemon, and only "), "{sentence}");
        assert!(!sentence.contains("--share") && sentence.lines().count() == 1, "{sentence}");
    }
}

#[test]
fn a_session_that_cannot_be_attached_to_is_named_in_a_sentence() {
    let session = Session::unique();
    let absent = |command: &mut Command| {
        let output = command.output().expect("it starts");
        let sentence = words(&output);
        assert_eq!(output.status.code(), Some(3), "{sentence}");
        assert!(sentence.contains(&format!("no session `{}` is running", session.name())), "{sentence}");
        assert_eq!(sentence.lines().count(), 1, "{sentence}");
    };
    absent(&mut biped(&["session", session.name()]));
    let waits = biped(&["session", session.name(), "--wait", "1.5"]).output().expect("it starts");
    assert!(words(&waits).starts_with("waiting for the session: 1 of 1.5 s\nerror: no session"), "{}", words(&waits));
    absent(&mut biped(&["controller", "--patience", "0.2", "--session", session.name()]));
    let mut stand = Command::new(python());
    absent(
        stand
            .arg("controller/foreign/python/stand.py")
            .env("BIPED_SESSION", session.name())
            .env("BIPED_PATIENCE", "0.2"),
    );
    names_the_owner_of_a_session(&session);
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "a refused controller leaves nothing");

    // The place of a controller is taken.
    let run = ["run", "stand", "--quiet", "--set", "duration=1000000", "--session", session.name()];
    let mut run = biped(&run).spawn().expect("the program starts");
    let set = ["set", "--session", session.name(), "--speed", "0.1"];
    wait_until("the controller answers", || {
        words(&biped(&set).output().expect("it starts")).contains("a robot that stands")
    });
    let second = biped(&["controller", "--session", session.name()]).output().expect("it starts");
    assert_eq!(second.status.code(), Some(5), "{}", words(&second));
    assert!(words(&second).contains("already has a controller"), "{}", words(&second));
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(run.id() as i32), nix::sys::signal::Signal::SIGTERM)
        .expect("alive");
    run.wait().expect("our own child");
    wait_until("the session has ended", || !session.is_running());
}

#[test]
fn a_process_by_hand_without_a_scene_is_told_how_to_start() {
    for role in ["plant", "controller"] {
        let output = biped(&[role]).env_remove("BIPED_SESSION").output().expect("the program starts");
        assert_eq!(output.status.code(), Some(2), "{}", words(&output));
        assert!(words(&output).contains("`biped plant walk` and `biped controller walk`"), "{}", words(&output));
    }
}
