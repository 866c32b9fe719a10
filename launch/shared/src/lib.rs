//! Parts that all commands share: arguments, built-in scenes, exit codes, output files, progress, threads.

pub mod args;
pub mod atomic_file;
pub mod csv;
pub mod exit;
pub mod interrupt;
pub mod list;
pub mod output;
pub mod progress;
pub mod share;
pub mod thread;
pub mod unsolved_problem;
