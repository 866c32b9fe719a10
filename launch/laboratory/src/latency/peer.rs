//! The other process: the same program in a hidden role, which answers as it is ordered to, line by line.

use super::bare;
use super::bench::{LOST, PATIENCE};
use super::carrier::null_plant;
use super::lines::{self, Wake};
use super::sockets::Socket;
use super::walk;
use clap::Args;
use controller::process::ProcessError;
use messages::clock::now_ns;
use messages::port::{Contract, ControllerPort, Pace, Waiting};
use messages::session::Session;
use messages::wire::{Command, Sensors, Stamp, Stamped};
use serde::{Deserialize, Serialize};
use sessions::children;
use sessions::open::open_with_timeout;
use sessions::process::Process;
use sessions::realtime::{RealtimeArgs, pin_to_nth};
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use std::io::{BufRead, BufReader, Write};
use std::os::fd::RawFd;
use std::process::{ChildStdin, ChildStdout, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
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

/// Arguments of the hidden role.
#[derive(Args)]
pub struct PeerArgs {
    /// Process to die with
    #[arg(long)]
    parent: i32,
}

/// The role: obeys until there are no more orders.
///
/// # Errors
/// Whatever a link breaks with.
pub fn serve(args: &PeerArgs, stop: &AtomicBool) -> Result<(), Failure> {
    children::die_with_parent(args.parent)?;
    pin_to_nth(1);
    for line in std::io::stdin().lines().map_while(Result::ok) {
        obey(serde_json::from_str(&line).map_err(|error| Failure::new(Exit::Usage, error))?, stop)?;
    }
    Ok(())
}

/// Tells the first process that it may begin.
fn ready() {
    print_text("ready\n");
}

fn obey(order: Order, stop: &AtomicBool) -> Result<(), Failure> {
    match order {
        Order::Lines { number, wake } => {
            let lines = lines::open(number)?;
            ready();
            lines.serve(wake)
        }
        Order::Unix { name, spins } => serve_socket(Socket::unix(&name, spins)?),
        Order::Udp { port, spins } => serve_socket(Socket::udp(port, spins)?),
        Order::Bare { session, ours } => {
            let session = Session::named(&session)?;
            let mut controller = bare::Controller::open(&session, ours)?;
            ready();
            controller.serve()
        }
        Order::Echo { session, waiting, system } => {
            let session = Session::named(&session)?;
            let port = open_with_timeout(|| ControllerPort::open(&session, &null_plant()))?;
            system.apply()?;
            echo(port.waiting(waiting), stop)
        }
        Order::Walk { session, waiting, seconds } => {
            let scene = walk::scene(seconds)?;
            let session = Session::named(&session)?;
            let port = open_with_timeout(|| ControllerPort::open(&session, &Contract::of(&scene, Pace::Lockstep)))?;
            ready();
            match controller::process::run(&scene, port.waiting(waiting), PATIENCE, stop) {
                Err(ProcessError::Interrupted) => Ok(()), // the first process says so
                ended => Ok(ended?),
            }
        }
    }
}

fn serve_socket(mut socket: Socket) -> Result<(), Failure> {
    ready();
    socket.serve()
}

/// A controller that does not think: its time stamp is when the sensors came.
fn echo(mut port: ControllerPort, stop: &AtomicBool) -> Result<(), Failure> {
    ready();
    let mut heard = now_ns();
    loop {
        match port.wait()?.filter(Sensors::is_sound) {
            Some(sensors) if sensors.last != 0 => return Ok(()),
            Some(sensors) => {
                let asked = sensors.stamp;
                let stamp = Stamp { run: asked.run, ack: asked.seq, seq: asked.seq, mono_ns: now_ns(), ..asked };
                port.send(Command { stamp, ..Command::default() })?;
                heard = asked.mono_ns;
            }
            None if stop.load(Relaxed) => return Ok(()),
            None if now_ns().saturating_sub(heard) > PATIENCE.as_nanos() as u64 => {
                return Err(Failure::new(Exit::PeerMissing, LOST));
            }
            None => (),
        }
    }
}
