//! The second process: the same program in a hidden role. It reads one order per line and executes it.

use super::bare;
use super::lines;
use super::second_process::Order;
use super::sockets::Socket;
use super::terms::{LOST, PATIENCE, null_plant};
use super::walk;
use clap::Args;
use controller::process::ProcessError;
use messages::clock::now_ns;
use messages::controller_session::ControllerSessionError;
use messages::port::{Contract, ControllerPort, Pace};
use messages::session::Session;
use messages::wire::{Command, Sensors, Stamp, Stamped};
use sessions::children;
use sessions::open::open_with_timeout;
use sessions::realtime::pin_to_nth;
use shared::exit::{Exit, Failure};
use shared::output::print_text;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

/// Arguments of the hidden role.
#[derive(Args)]
pub struct PeerArgs {
    /// Process whose end ends this one
    #[arg(long)]
    parent: i32,
}

/// Runs the second process: executes orders until there are no more.
///
/// # Errors
/// The failure of a link.
pub fn serve(args: &PeerArgs, stop: &AtomicBool) -> Result<(), Failure> {
    children::die_with_parent(args.parent)?;
    pin_to_nth(1);
    for line in std::io::stdin().lines().map_while(Result::ok) {
        obey(serde_json::from_str(&line).map_err(|error| Failure::new(Exit::Usage, error))?, stop)?;
    }
    Ok(())
}

/// Reports to the first process that this one is ready.
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
            let mut controller = bare::BareController::open(&session, ours)?;
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
                Err(ProcessError::Session(ControllerSessionError::Interrupted)) => Ok(()), // the first process reports it
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
