//! `biped view`: the page in 3-D, of a session that is running or of a recording. The same page is in `report.html`.

pub mod film;
mod live;
pub mod page;
mod recorded;
mod server;

use crate::desk::SessionArgs;
use crate::exit::Failure;
use clap::Args;
use std::path::PathBuf;
use std::sync::atomic::AtomicBool;

/// Arguments of `biped view`.
#[derive(Args)]
pub struct ViewArgs {
    /// Show this recording of `biped run --record` instead of a running session
    #[arg(conflicts_with = "session")]
    file: Option<PathBuf>,
    #[command(flatten)]
    session: SessionArgs,
    /// Port on this machine's own address; 0 takes one that is free
    #[arg(long, default_value_t = 8642)]
    port: u16,
    /// Write the page of the recording into this file, instead of serving it
    #[arg(long, value_name = "FILE", requires = "file", conflicts_with = "session")]
    out: Option<PathBuf>,
}

/// Shows it until the session or the user's patience ends.
///
/// # Errors
/// If there is no such session or recording, or the port is in use.
pub fn run(args: &ViewArgs, stop: &AtomicBool) -> Result<(), Failure> {
    match &args.file {
        Some(file) => recorded::run(file, args.out.as_deref(), args.port, stop),
        None => live::run(&args.session.find()?, args.port, stop),
    }
}
