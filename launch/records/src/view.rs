//! `biped view`: the page in 3-D, of a session that is running or of a recording. The same page is in `report.html`.

mod access;
pub mod frame;
mod live;
pub mod page;
mod recorded;
mod server;

use clap::Args;
use shared::args::SessionArgs;
use shared::exit::Failure;
use std::net::{IpAddr, Ipv4Addr, SocketAddr};
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
    /// Address of this machine to listen on, for browsers on others: 0.0.0.0 or :: are all of its addresses
    #[arg(long, value_name = "ADDRESS", value_parser = address, default_value_t = Ipv4Addr::LOCALHOST.into())]
    listen: IpAddr,
    /// Port on that address; 0 takes one that is free
    #[arg(long, default_value_t = 8642)]
    port: u16,
    /// Show no progress
    #[arg(long)]
    quiet: bool,
    /// Write the page of the recording into this file, instead of serving it
    #[arg(long, value_name = "FILE", requires = "file", conflicts_with = "session")]
    out: Option<PathBuf>,
}

fn address(text: &str) -> Result<IpAddr, String> {
    text.parse()
        .map_err(|_| "an IP address of this machine is needed, such as 0.0.0.0 or ::1; the port is --port".into())
}

/// Shows it until the session or the user's patience ends.
///
/// # Errors
/// If there is no such session or recording, or the address cannot be listened on.
pub fn run(args: &ViewArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let place = SocketAddr::new(args.listen, args.port);
    match &args.file {
        Some(file) => recorded::run(file, args.out.as_deref(), place, args.quiet, stop),
        None => live::run(&args.session.find()?, place, stop),
    }
}
