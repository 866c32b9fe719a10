//! The other process: the same program in a hidden role. It reads orders line by line and answers accordingly.

use super::bare;
use super::bench::{LOST, PATIENCE};
use super::carrier::null_plant;
use super::lines::{self, Wake};
use super::sockets::Socket;
use super::walk;
use crate::exit::{Exit, Failure};
use crate::output::say;
use crate::realtime::{RealtimeArgs, keep_to};
use crate::{children, guarded};
use clap::Args;
use controller::process::ProcessError;
use messages::clock::now_ns;
use messages::port::{Contract, ControllerPort, Pace, Waiting};
use messages::session::Session;
use messages::wire::{Command, Sensors, Stamp, Stamped};
use serde::{Deserialize, Serialize};
use std::io::{BufRead, BufReader, Write};
use std::os::fd::RawFd;
use std::process::{Child, ChildStdin, ChildStdout, Command as Process, Stdio};
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};
use std::time::{Duration, Instant};

/// Time limit for the other process to end by itself.
const GRACE: Duration = Duration::from_secs(1);

/// An order: what the other process does until the end is announced.
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
pub struct Peer {
    process: Child,
    /// Closing it ends the other process.
    orders: Option<ChildStdin>,
    answers: BufReader<ChildStdout>,
}

impl Peer {
    /// Starts it.
    ///
    /// # Errors
    /// A system that cannot start it.
    pub fn start() -> Result<Peer, Failure> {
        let failed = |error: &dyn std::fmt::Display| {
            Failure::new(Exit::Fault, format!("the other process of the measurement cannot be started: {error}"))
        };
        let mut process = Process::new(std::env::current_exe().map_err(|error| failed(&error))?)
            .args(["latency-peer", "--parent", &std::process::id().to_string()])
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .map_err(|error| failed(&error))?;
        match (process.stdin.take(), process.stdout.take()) {
            (orders @ Some(_), Some(answers)) => Ok(Peer { process, orders, answers: BufReader::new(answers) }),
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

impl Drop for Peer {
    /// Ends the process, by force if necessary.
    fn drop(&mut self) {
        drop(self.orders.take());
        let start = Instant::now();
        while matches!(self.process.try_wait(), Ok(None)) && start.elapsed() < GRACE {
            std::thread::sleep(Duration::from_millis(1));
        }
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Arguments of the hidden role.
#[derive(Args)]
pub struct PeerArgs {
    /// Process whose end ends this one
    #[arg(long)]
    parent: i32,
}

/// The role: executes orders until there are no more.
///
/// # Errors
/// The failure of a link.
pub fn serve(args: &PeerArgs, stop: &AtomicBool) -> Result<(), Failure> {
    children::die_with(args.parent)?;
    keep_to(1);
    for line in std::io::stdin().lines().map_while(Result::ok) {
        obey(serde_json::from_str(&line).map_err(|error| Failure::new(Exit::Usage, error))?, stop)?;
    }
    Ok(())
}

/// Tells the first process that this one is ready.
fn ready() {
    say("ready\n");
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
            let port = guarded(|| ControllerPort::open(&session, &null_plant()))?;
            system.prepare()?;
            echo(port.waiting(waiting), stop)
        }
        Order::Walk { session, waiting, seconds } => {
            let scene = walk::scene(seconds)?;
            let session = Session::named(&session)?;
            let port = guarded(|| ControllerPort::open(&session, &Contract::of(&scene, Pace::Lockstep)))?;
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

/// A controller without computation. Its time stamp is the arrival time of the sensors.
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
