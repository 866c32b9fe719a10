//! `cargo bench`: the cost of every part of a control period.
//!
//! | command | measures |
//! |---|---|
//! | `cargo bench` | everything below except the peers |
//! | `cargo bench -- step` | benchmarks with this word in their names; `--help` lists more options |
//! | `cargo bench -- tail` | the slowest steps of a walk |
//! | `cargo bench -- methods` | the default method compared with the paper's |
//! | `cargo bench -- --peers` | a comparison with MuJoCo, Pinocchio and four QP solvers, on the same states and programs |
//! | `cargo bench -- link` | round trips and the lockstep walk, with two processes |
//!
//! Times depend on the machine and its other load, so compare only medians of the same session.

#![expect(clippy::expect_used, reason = "a bench may panic")]

mod contact;
#[path = "../../launch/laboratory/src/chart/core.rs"]
mod core;
mod dynamics;
mod link;
mod methods;
mod peers;
mod rate;
mod robot;
mod step;
mod tail;

use self::core::Core;

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let words: Vec<_> = arguments.iter().filter(|word| !word.starts_with('-')).collect();
    let asked = |name: &str| words.is_empty() || words.iter().any(|word| name.contains(word.as_str()));
    if arguments.iter().any(|word| word == "--peers") {
        return peers::print();
    }
    let core = Core::hold();
    divan::main();
    if !arguments.iter().any(|word| word == "--bench") || arguments.iter().any(|word| word == "--list") {
        return; // `cargo test` only checks that it starts
    }
    if asked("tail") {
        tail::print();
    }
    if asked("methods") {
        methods::print();
    }
    println!("{}", core.remark());
    drop(core); // two processes need two cores
    if asked("link") {
        link::print();
    }
}
