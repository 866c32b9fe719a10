//! `biped list --hashes`: hashes of the states of every built-in scene.
//!
//! `messages/scenes/hashes.txt` is a copy of this list, and tests compare with it. Renew it after a change of bits that is intended:
//!
//! ```text
//! cargo run --release -- list --hashes > messages/scenes/hashes.txt
//! ```

use messages::load::load;
use rayon::prelude::*;
use sessions::run::in_process;
use shared::exit::{Failure, check_interrupt};
use shared::list::SCENES;
use shared::output::print_text;
use std::sync::atomic::AtomicBool;

/// Prints the hash of all states of the first second and of the whole run, for every scene.
///
/// # Errors
/// Ctrl-C, or a bad scene, which a test excludes.
pub fn print(stop: &AtomicBool) -> Result<(), Failure> {
    let rows = SCENES.par_iter().map(|&(name, _)| row(name, stop)).collect::<Result<String, Failure>>()?;
    print_text(format!("{:<16} {:<16} {:<16} {}\n{rows}", "scene", "first second", "whole run", "s"));
    Ok(())
}

fn row(name: &str, stop: &AtomicBool) -> Result<String, Failure> {
    let scene = load(name, &[], SCENES)?;
    let (mut first, mut whole, mut end) = (0, 0, 0);
    let outcome = in_process(&scene, |truth| {
        (whole, end) = (truth.hash, truth.stamp.sim_ns);
        if truth.stamp.seq <= 1 + scene.rate.round() as u64 {
            first = whole;
        }
        check_interrupt(stop)
    });
    check_interrupt(stop)?;
    let remark = outcome.err().map(|failure| format!(" {}", failure.message)).unwrap_or_default();
    Ok(format!("{name:<16} {first:016x} {whole:016x} {:.1}{remark}\n", end as f64 * 1e-9))
}
