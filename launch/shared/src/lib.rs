//! What all commands share: exit codes, output, progress, arguments, built-in scenes.

pub mod args;
pub mod case;
pub mod csv;
pub mod exit;
pub mod list;
pub mod output;
pub mod progress;
pub mod whole;
