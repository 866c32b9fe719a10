//! The first process's handle of the second process: it starts the second process, sends orders to it and ends it.

use super::lines::Wake;
use super::terms::LOST;
use messages::port::Waiting;
use serde::{Deserialize, Serialize};
use sessions::process::{Process, child_command};
use sessions::realtime::RealtimeArgs;
use shared::exit::{Exit, Failure};
use std::io::{BufRead, BufReader, Write};
use std::os::fd::RawFd;
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::time::Duration;

/// Time limit for the other process to end by itself.
const GRACE: Duration = Duration::from_secs(1);

/// An order: the task of the other process until the end is announced.
#[derive(Serialize, Deserialize)]
pub enum Order {
    /// Answer over two cache lines.
    Lines { number: RawFd, wake: Wake },
    /// Answer over a Unix socket.
    Unix { name: String, spins: bool },
    /// Answer over UDP.
    Udp { port: u16, spins: bool },
    /// Answer sensors by commands without stamps and check sums, over iceoryx2 alone or our ports.
    Bare { session: String, ours: bool },
    /// Answer sensors by commands at once.
    Echo { session: String, waiting: Waiting, system: RealtimeArgs },
    /// Run the controller of a walk in lockstep.
    Walk { session: String, waiting: Waiting, seconds: f64 },
}

/// The first process's handle of the other process.
pub struct SecondProcess {
    process: Process,
    /// Standard input of the other process. When it is closed, the other process ends.
    orders: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl SecondProcess {
    /// Starts the other process.
    ///
    /// # Errors
    /// A system that cannot start it.
    pub fn start() -> Result<SecondProcess, Failure> {
        let failed = |error: &dyn std::fmt::Display| {
            Failure::new(Exit::Fault, format!("the other process of the measurement cannot be started: {error}"))
        };
        let start = || {
            let mut command = child_command(&["latency-peer".into()])?;
            Process::start(command.stdin(Stdio::piped()).stdout(Stdio::piped()))
        };
        let mut process = start().map_err(|error| failed(&error))?;
        match (process.stdin(), process.stdout()) {
            (orders @ Some(_), Some(answers)) => {
                Ok(SecondProcess { process, orders, answers: BufReader::new(answers) })
            }
            _ => Err(failed(&"it has no pipes")),
        }
    }

    /// Sends an order and waits until the other process is ready.
    ///
    /// # Errors
    /// A process that has ended.
    pub fn order(&mut self, order: &Order) -> Result<(), Failure> {
        let lost = || Failure::new(Exit::PeerMissing, LOST);
        let line = serde_json::to_string(order).map_err(|error| Failure::new(Exit::Fault, error))?;
        let orders = self.orders.as_mut().ok_or_else(lost)?;
        writeln!(orders, "{line}").map_err(|_| lost())?;
        let read = self.answers.read_line(&mut String::new());
        read.ok().filter(|length| *length > 0).map(drop).ok_or_else(lost)
    }
}

impl Drop for SecondProcess {
    /// Lets the second process end regularly, and kills it if it does not.
    fn drop(&mut self) {
        drop(self.orders.take());
        self.process.wait(GRACE);
    }
}
