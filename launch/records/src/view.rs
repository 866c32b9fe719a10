//! `biped view`: serves the 3-D page of a running session or of a recording. `report.html` contains the same page.

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
    /// Show this recording (see `biped run --record`) instead of a running session
    #[arg(conflicts_with = "session")]
    file: Option<PathBuf>,
    #[command(flatten)]
    session: SessionArgs,
    /// Local IP address to listen on; 0.0.0.0 or :: accept connections from other machines on all addresses
    #[arg(long, value_name = "ADDRESS", value_parser = parse_address, default_value_t = Ipv4Addr::LOCALHOST.into())]
    listen: IpAddr,
    /// Port to listen on; 0 selects a free port
    #[arg(long, default_value_t = 8642)]
    port: u16,
    #[arg(from_global)]
    quiet: bool,
    /// Write the page of the recording into this file instead of serving it
    #[arg(long, value_name = "FILE", requires = "file", conflicts_with_all = ["session", "listen", "port"])]
    out: Option<PathBuf>,
}

fn parse_address(text: &str) -> Result<IpAddr, String> {
    text.parse()
        .map_err(|_| "an IP address of this machine is needed, such as 0.0.0.0 or ::1; set the port with --port".into())
}

/// Serves the page until the session ends or the user stops the program.
///
/// # Errors
/// If the session or recording does not exist, or the program cannot listen on the address.
pub fn run(args: &ViewArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let address = SocketAddr::new(args.listen, args.port);
    match &args.file {
        Some(file) => recorded::run(file, args.out.as_deref(), address, args.quiet, stop),
        None => live::run(&args.session.find()?, address, stop),
    }
}
