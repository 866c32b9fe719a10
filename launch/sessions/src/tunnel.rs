//! `biped tunnel`: a session across two machines, through the tunnel of the iceoryx2 project. Sensors go one way, commands the other.

use crate::process::Process;
use clap::Args;
use messages::session::Session;
use shared::exit::{Exit, Failure};
use shared::output::temporary_folder;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// The tunnel program of the iceoryx2 project.
const PROGRAM: &str = "iox2-link-tunnel-zenoh";
/// The command that installs it.
const INSTALL_COMMAND: &str = "cargo install iceoryx2-integrations-zenoh-link-tunnel-cli --version 0.10.0";
/// The topics that cross the tunnel: those between a robot and its controller. All others stay local.
const TOPICS: [&str; 2] = ["biped/sensors", "biped/command"];
/// Interval at which session and tunnel are checked.
const POLL_INTERVAL: Duration = Duration::from_millis(200);
/// Time that the tunnel gets to transmit the last messages after all other members have left.
const FLUSH_TIME: Duration = Duration::from_millis(500);

/// Arguments of `biped tunnel`.
#[derive(Args)]
pub struct TunnelArgs {
    /// Name of the session. Its plant or controller must have been started with --tunnel
    #[arg(long, default_value = "biped")]
    session: String,
    /// Wait for a connection at this endpoint, for example tcp/0.0.0.0:7447
    #[arg(long, value_name = "ENDPOINT", required_unless_present = "connect")]
    listen: Option<String>,
    /// Connect to this endpoint of the other machine, for example tcp/192.168.1.2:7447
    #[arg(long, value_name = "ENDPOINT")]
    connect: Option<String>,
    /// Interval at which the tunnel looks for new messages [ms]
    #[arg(long, default_value_t = 1, value_name = "MS")]
    poll: u64,
}

/// Runs the tunnel until the session ends.
///
/// # Errors
/// If there is no session, or the tunnel is not installed or fails.
pub fn run(args: &TunnelArgs, stop: &AtomicBool) -> Result<(), Failure> {
    let session = Session::named(&args.session)?;
    if !session.is_running() {
        let name = session.name();
        let why = format!("session `{name}` is not running: start its plant or controller first, with --tunnel");
        return Err(Failure::new(Exit::PeerMissing, why));
    }
    // The last member to leave removes the files. Being one delays that until the tunnel has transmitted the last messages.
    let member = session.join()?;
    let folder = temporary_folder("tunnel")?;
    let result = write_config(args, &session, &folder)
        .and_then(|()| start(args, &folder))
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => {
                Failure::new(Exit::Usage, format!("{PROGRAM} is not installed: {INSTALL_COMMAND}"))
            }
            _ => Failure::new(Exit::Fault, format!("the tunnel cannot be started: {error}")),
        })
        .and_then(|tunnel| watch(tunnel, &session, stop));
    let _ = std::fs::remove_dir_all(&folder);
    drop(member);
    result
}

/// Writes the configuration files of the tunnel: the location of the session in shared memory, and the endpoints.
fn write_config(args: &TunnelArgs, session: &Session, folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder.join("config"))?;
    let root = session.root().display().to_string();
    let location = format!("[global]\nprefix = {:?}\nroot-path = {root:?}\n", session.prefix());
    std::fs::write(folder.join("config/iceoryx2.toml"), location)?;
    let endpoints = |endpoint: &Option<String>| serde_json::json!({ "endpoints": endpoint.iter().collect::<Vec<_>>() });
    let (listen, connect) = (endpoints(&args.listen), endpoints(&args.connect));
    let multicast = serde_json::json!({ "multicast": { "enabled": false } });
    let network = serde_json::json!({ "mode": "peer", "listen": listen, "connect": connect, "scouting": multicast });
    std::fs::write(folder.join("zenoh.json5"), network.to_string())
}

fn start(args: &TunnelArgs, folder: &Path) -> std::io::Result<Process> {
    let mut command = Command::new(PROGRAM);
    command.current_dir(folder).args(["--zenoh-config", "zenoh.json5", "--reactive"]);
    command.args(["--poll", &args.poll.to_string()]).args(TOPICS.iter().flat_map(|topic| ["--allow", topic]));
    Process::start(command.stdin(Stdio::null()))
}

fn watch(mut tunnel: Process, session: &Session, stop: &AtomicBool) -> Result<(), Failure> {
    let is_alone = || session.members() == [std::process::id()];
    loop {
        match tunnel.try_wait() {
            _ if stop.load(Relaxed) => return Err(Failure::new(Exit::Interrupted, "interrupted")),
            None if !is_alone() => std::thread::sleep(POLL_INTERVAL),
            None => {
                std::thread::sleep(FLUSH_TIME);
                return Ok(());
            }
            Some(status) => return Err(Failure::new(Exit::Fault, format!("the tunnel ended: {status}"))),
        }
    }
}
