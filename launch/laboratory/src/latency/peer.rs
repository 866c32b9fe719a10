//! The other process, as the first one sees it: started, ordered, ended.

use super::lines::Wake;
use super::terms::LOST;
use messages::port::Waiting;
use serde::{Deserialize, Serialize};
use sessions::process::Process;
use sessions::realtime::RealtimeArgs;
use shared::exit::{Exit, Failure};
use std::io::{BufRead, BufReader, Write};
use std::os::fd::RawFd;
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::time::Duration;

/// Time that the other process gets to end in order.
const GRACE: Duration = Duration::from_secs(1);

/// What the other process is to do next, until it is told that this is over.
#[derive(Serialize, Deserialize)]
pub enum Order {
    /// Answer over two cache lines.
    Lines { number: RawFd, wake: Wake },
    /// Answer over a Unix socket.
    Unix { name: String, spins: bool },
    /// Answer over UDP.
    Udp { port: u16, spins: bool },
    /// Answer sensors by commands that are neither stamped nor sealed, over iceoryx2 alone or our ports.
    Bare { session: String, ours: bool },
    /// Answer sensors by commands at once.
    Echo { session: String, waiting: Waiting, system: RealtimeArgs },
    /// Be the controller of a walk in lockstep.
    Walk { session: String, waiting: Waiting, seconds: f64 },
}

/// The other process, as the first one sees it.
pub struct Peer {
    process: Process,
    /// Its end tells the other process to end.
    orders: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts it.
    ///
    /// # Errors
    /// If the system cannot.
    pub fn start() -> Result<Peer, Failure> {
        let failed = |error: &dyn std::fmt::Display| {
            Failure::new(Exit::Fault, format!("the other process of the measurement cannot be started: {error}"))
        };
        let mut process = Process::start(
            std::process::Command::new(std::env::current_exe().map_err(|error| failed(&error))?)
                .args(["latency-peer", "--parent", &std::process::id().to_string()])
                .stdin(Stdio::piped())
                .stdout(Stdio::piped()),
        )
        .map_err(|error| failed(&error))?;
        match (process.stdin(), process.stdout()) {
            (orders @ Some(_), Some(answers)) => Ok(Peer { process, orders, answers: BufReader::new(answers) }),
            _ => Err(failed(&"it has no pipes")),
        }
    }

    /// Gives an order, and waits until it is ready to answer.
    ///
    /// # Errors
    /// If it has ended.
    pub fn order(&mut self, order: &Order) -> Result<(), Failure> {
        let lost = || Failure::new(Exit::PeerMissing, LOST);
        let line = serde_json::to_string(order).map_err(|error| Failure::new(Exit::Fault, error))?;
        let orders = self.orders.as_mut().ok_or_else(lost)?;
        writeln!(orders, "{line}").map_err(|_| lost())?;
        let read = self.answers.read_line(&mut String::new());
        read.ok().filter(|length| *length > 0).map(drop).ok_or_else(lost)
    }
}

impl Drop for Peer {
    /// Lets it end in order; what does not is killed.
    fn drop(&mut self) {
        drop(self.orders.take());
        self.process.wait(GRACE);
    }
}
