//! The examples run to their end, and the assertions in them hold.

#[path = "../examples/fall.rs"]
mod fall;
#[path = "../examples/one_step.rs"]
mod one_step;
#[path = "../examples/own_controller.rs"]
mod own_controller;
#[path = "../examples/own_law.rs"]
mod own_law;

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
