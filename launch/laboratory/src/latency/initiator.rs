//! The plant's end of a connection on which every message is timed.

use super::results::Results;
use super::spread::Spread;
use super::terms::{LOST, PATIENCE};
use messages::clock::now_ns;
use messages::port::{Contract, PlantPort, Waiting};
use messages::session::Session;
use messages::wire::{Command, Sensors, Stamp, Stamped};
use sessions::open::open_with_timeout;
use shared::exit::{Exit, Failure, check_interrupt};
use std::sync::atomic::AtomicBool;

/// The connection and its measured times.
pub struct Initiator<'a> {
    port: PlantPort,
    stop: &'a AtomicBool,
    latest: Stamp,
    /// Arrival time of the last command.
    pub received_ns: u64,
    /// Times of the way there, the way back and the round trip [ns]. Histograms are made at the end, because they cost time.
    times: Vec<[u64; 3]>,
}

/// An upper limit on the number of exchanges.
const MOST: usize = 1 << 16;

impl<'a> Initiator<'a> {
    /// Joins a session as the plant.
    ///
    /// # Errors
    /// If the session cannot be made.
    pub fn open(
        session: &Session,
        contract: &Contract,
        waiting: Waiting,
        stop: &'a AtomicBool,
    ) -> Result<Initiator<'a>, Failure> {
        let port = open_with_timeout(|| PlantPort::open(session, contract))?.waiting(waiting);
        Ok(Initiator { port, stop, latest: Stamp::default(), received_ns: 0, times: Vec::with_capacity(MOST) })
    }

    /// A first exchange, which is not counted: the other side may still be starting.
    ///
    /// # Errors
    /// As [`Initiator::exchange`].
    pub fn first_exchange(&mut self) -> Result<(), Failure> {
        let stamp = Stamp { seq: 1, mono_ns: now_ns(), ..Stamp::default() };
        self.ask(&Sensors { stamp, ..Sensors::default() }).map(drop)
    }

    /// Sends sensors with the time of sending, waits for the answer, and counts the times.
    ///
    /// # Errors
    /// A link that breaks, no answer in time, or Ctrl-C.
    #[inline]
    pub fn exchange(&mut self, sensors: Sensors) -> Result<Command, Failure> {
        let command = self.ask(&sensors)?;
        let (sent, stamped) = (sensors.stamp.mono_ns, command.stamp.mono_ns);
        let (there, back) = (stamped.saturating_sub(sent), self.received_ns.saturating_sub(stamped));
        self.times.push([there, back, self.received_ns - sent]);
        Ok(command)
    }

    /// The same without counting.
    ///
    /// # Errors
    /// As [`Initiator::exchange`].
    #[inline]
    pub fn ask(&mut self, sensors: &Sensors) -> Result<Command, Failure> {
        self.latest = sensors.stamp;
        self.port.send(*sensors)?;
        loop {
            let command = self.port.wait()?.filter(Command::is_sound);
            self.received_ns = now_ns();
            match command {
                Some(command) if command.stamp.ack == self.latest.seq => return Ok(command),
                Some(_) => (),
                None => check_interrupt(self.stop)?,
            }
            if self.received_ns.saturating_sub(self.latest.mono_ns) > PATIENCE.as_nanos() as u64 {
                return Err(Failure::new(Exit::PeerMissing, LOST));
            }
        }
    }

    /// Sends the end message and adds the counts to the results.
    ///
    /// # Errors
    /// If the link breaks.
    pub fn end(self, results: &mut Results, section: &'static str) -> Result<(), Failure> {
        let stamp = Stamp { seq: self.latest.seq + 1, mono_ns: now_ns(), ..self.latest };
        self.port.send(Sensors { stamp, last: 1, ..Sensors::default() })?;
        for (metric, which) in [("round trip", 2), ("sensors to command", 0), ("command to plant", 1)] {
            results.put(section, metric, &Spread::of(self.times.iter().map(|times| times[which]))?);
        }
        Ok(())
    }
}
