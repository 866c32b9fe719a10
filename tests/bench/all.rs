//! `cargo bench`: what every part of a period costs.
//!
//! | command | measures |
//! |---|---|
//! | `cargo bench` | everything below but the peers |
//! | `cargo bench -- step` | what has this word in its name; `--help` lists more |
//! | `cargo bench -- tail` | the slowest steps of a walk |
//! | `cargo bench -- methods` | the default method beside the paper's |
//! | `cargo bench -- --peers` | a table beside MuJoCo, Pinocchio and four QP solvers, on the same states and programs |
//! | `cargo bench -- link` | round trips and the walk in lockstep, two processes |
//!
//! Times are of the machine and of what else it does: compare medians of one session.

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
        return; // `cargo test` asks whether it runs
    }
    if asked("tail") {
        tail::print();
    }
    if asked("methods") {
        methods::print();
    }
    println!("{}", core.remark());
    drop(core); // two processes want two
    if asked("link") {
        link::print();
    }
}
