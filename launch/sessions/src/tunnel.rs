//! `biped tunnel`: a session over two machines, by iceoryx2's own tunnel: sensors go one way, commands the other.

use crate::process::Process;
use clap::Args;
use messages::session::Session;
use nix::unistd::mkdtemp;
use shared::exit::{Exit, Failure};
use shared::output::unwritten;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::Duration;

/// What carries the messages: the tunnel of iceoryx2's authors.
const PROGRAM: &str = "iox2-link-tunnel-zenoh";
const PACKAGE: &str = "cargo install iceoryx2-integrations-zenoh-link-tunnel-cli --version 0.10.0";
/// The topics that a robot and its computer share; everything else stays where it is.
const TOPICS: [&str; 2] = ["biped/sensors", "biped/command"];
/// Whether session and tunnel live is looked up this often.
const LOOK: Duration = Duration::from_millis(200);
/// Time for the last words to get over, once those who said them have ended.
const GOODBYE: Duration = Duration::from_millis(500);

/// Arguments of `biped tunnel`.
#[derive(Args)]
pub struct TunnelArgs {
    /// Name of the session, in which a plant or a controller runs that was started with --tunnel
    #[arg(long, default_value = "biped")]
    session: String,
    /// Wait for the other machine here, for example tcp/0.0.0.0:7447
    #[arg(long, value_name = "ENDPOINT", required_unless_present = "connect")]
    listen: Option<String>,
    /// Go to the other machine there, for example tcp/192.168.1.2:7447
    #[arg(long, value_name = "ENDPOINT")]
    connect: Option<String>,
    /// Look for new messages so often [ms]
    #[arg(long, default_value_t = 1, value_name = "MS")]
    poll: u64,
}

/// Carries the session until it ends.
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
    // The last one out sweeps: not before the tunnel has carried the last words.
    let member = session.join()?;
    let folder = private_folder()?;
    let ended = settings(args, &session, &folder)
        .and_then(|()| start(args, &folder))
        .map_err(|error| match error.kind() {
            std::io::ErrorKind::NotFound => Failure::new(Exit::Usage, format!("{PROGRAM} is not installed: {PACKAGE}")),
            _ => Failure::new(Exit::Fault, format!("the tunnel cannot be started: {error}")),
        })
        .and_then(|tunnel| watch(tunnel, &session, stop));
    let _ = std::fs::remove_dir_all(&folder);
    drop(member);
    ended
}

/// A new folder for this user alone, under a name that nobody can lay something under beforehand.
fn private_folder() -> Result<PathBuf, Failure> {
    let folder = std::env::temp_dir().join("biped-tunnel-XXXXXX");
    mkdtemp(&folder).map_err(|error| unwritten(&folder, &error))
}

/// What the tunnel reads of files: where the session lies in shared memory, and where the other machine is.
fn settings(args: &TunnelArgs, session: &Session, folder: &Path) -> std::io::Result<()> {
    std::fs::create_dir_all(folder.join("config"))?;
    let root = session.root().display().to_string();
    let place = format!("[global]\nprefix = {:?}\nroot-path = {root:?}\n", session.prefix());
    std::fs::write(folder.join("config/iceoryx2.toml"), place)?;
    let at = |endpoint: &Option<String>| serde_json::json!({ "endpoints": endpoint.iter().collect::<Vec<_>>() });
    let (listen, connect) = (at(&args.listen), at(&args.connect));
    let multicast = serde_json::json!({ "multicast": { "enabled": false } });
    let way = serde_json::json!({ "mode": "peer", "listen": listen, "connect": connect, "scouting": multicast });
    std::fs::write(folder.join("zenoh.json5"), way.to_string())
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
        match tunnel.ended() {
            _ if stop.load(Relaxed) => return Err(Failure::new(Exit::Interrupted, "interrupted")),
            None if !is_alone() => std::thread::sleep(LOOK),
            None => {
                std::thread::sleep(GOODBYE);
                return Ok(());
            }
            Some(status) => return Err(Failure::new(Exit::Fault, format!("the tunnel ended: {status}"))),
        }
    }
}
