//! Claims about controllers that are started by hand: they attach to a running session by its name alone, in every language,
//! whichever side starts first. If that is not possible, the program ends with a sentence and an exit code.

#![expect(clippy::expect_used, reason = "a test may panic")]

mod common;
#[path = "common/languages.rs"]
mod languages;

use languages::{compile, python};
use messages::session::Session;
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

/// Asserts that both processes exit with code 0 and leave no file.
fn ends_well(session: &Session, what: &str, plant: Child, controller: Output) {
    let plant = plant.wait_with_output().expect("our own child");
    assert_eq!((controller.status.code(), words(&controller)), (Some(0), String::new()), "{what}");
    assert_eq!(plant.status.code(), Some(0), "{what}: {}", words(&plant));
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "{what}: left in shared memory");
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
    let ways: [(&str, Start); 5] =
        [("Rust", &by_name), ("Python", &of_python), ("C", &of_c), ("variable", &ours), ("shell", &by_shell)];
    for (what, command) in ways {
        let session = Session::unique();
        let plant = plant(&session);
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
    ends_well(&session, "first", plant, controller.wait_with_output().expect("our own child"));
}

#[test]
fn biped_session_prints_the_contract_as_json_and_for_an_editor() {
    let session = Session::unique();
    let mut plant = plant(&session);
    let printed = |format: &str| {
        let output =
            biped(&["session", session.name(), "--wait", "60", "--format", format]).output().expect("it starts");
        assert_eq!(output.status.code(), Some(0), "{}", words(&output));
        serde_json::from_slice::<Value>(&output.stdout).expect("JSON")
    };
    let environment = printed("json");
    assert_eq!(environment["BIPED_SESSION"], session.name());
    let contract = environment["BIPED_CONTRACT"].as_str().expect("text");
    assert!(contract.contains("pace=lockstep\n") && contract.contains("rate=1000 Hz\n"), "{contract}");
    let scene: Value = serde_json::from_str(environment["BIPED_SCENE"].as_str().expect("text")).expect("JSON");
    assert_eq!(scene["duration"], 1.0, "as it runs");
    // the wait of this command is not the patience of the program that gets the environment
    assert_eq!(environment["BIPED_PATIENCE"], "10");
    let at_once = biped(&["session", session.name(), "--format", "json"]).output().expect("it starts").stdout;
    assert_eq!(serde_json::from_slice::<Value>(&at_once).expect("JSON"), environment);
    assert_eq!(printed("vscode")["env"], environment);
    plant.kill().expect("our own child");
    plant.wait().expect("our own child");
    session.remove_files();
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
    absent(&mut biped(&["controller", "--patience", "0.2", "--session", session.name()]));
    let mut stand = Command::new(python());
    absent(
        stand
            .arg("controller/foreign/python/stand.py")
            .env("BIPED_SESSION", session.name())
            .env("BIPED_PATIENCE", "0.2"),
    );
    assert_eq!(session.shm_files(), [""; 0].map(PathBuf::from), "a refused controller leaves nothing");

    // The place of a controller is taken.
    let run = ["run", "stand", "--quiet", "--set", "duration=1000000", "--session", session.name()];
    let mut run = biped(&run).spawn().expect("the program starts");
    wait_until("the session runs", || session.environment().is_some() && session.members().len() == 3);
    let second = biped(&["controller", "--session", session.name()]).output().expect("it starts");
    assert_eq!(second.status.code(), Some(5), "{}", words(&second));
    assert!(words(&second).contains("already has a controller"), "{}", words(&second));
    nix::sys::signal::kill(nix::unistd::Pid::from_raw(run.id() as i32), nix::sys::signal::Signal::SIGTERM)
        .expect("alive");
    run.wait().expect("our own child");
    wait_until("the session has ended", || !session.is_running());
}
