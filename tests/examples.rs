//! The examples run to their end, and the assertions in them hold.

#[path = "../examples/fall.rs"]
mod fall;
#[path = "../examples/one_step.rs"]
mod one_step;
#[path = "../examples/own_controller.rs"]
mod own_controller;
#[path = "../examples/own_law.rs"]
mod own_law;
#[path = "../examples/own_process.rs"]
#[allow(dead_code, reason = "its main reads the arguments of a program of its own")]
mod own_process;

use messages::controller_program::control;
use messages::exit::Exit;
use messages::session::Session;
use own_process::Stand;
use std::process::Command;
use std::sync::atomic::AtomicBool;

static NEVER: AtomicBool = AtomicBool::new(false);

#[test]
fn a_falling_body_lands_where_and_when_it_must() {
    fall::main().expect("it runs");
}

#[test]
fn the_stages_of_a_step_give_the_step() {
    one_step::main().expect("it runs");
}

#[test]
fn a_controller_of_twenty_lines_stands() {
    own_controller::main().expect("it runs");
}

#[test]
fn an_own_law_converges_by_the_certificate() {
    own_law::main().expect("it runs");
}

#[test]
fn a_controller_of_its_own_attaches_to_a_session_by_its_name_until_the_end_of_the_scene() {
    let session = Session::unique();
    let mut plant = Command::new(env!("CARGO_BIN_EXE_biped"))
        .args(["plant", "stand", "--set", "duration=1", "--session", session.name()])
        .spawn()
        .expect("the program starts");
    let controlled = control::<Stand>(Some(session.name()), &NEVER);
    assert!(plant.wait().expect("it ends").success());
    controlled.expect("it answers until the goodbye");
}

#[test]
fn a_session_that_cannot_be_is_refused_with_its_exit_code() {
    let error = control::<Stand>(Some("no/such"), &NEVER).expect_err("no name of a session");
    assert_eq!(
        (error.exit_code(), error.to_string().contains("`no/such` cannot name a session")),
        (Exit::Usage, true),
        "{error}"
    );
}
