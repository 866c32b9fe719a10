//! An exchange of the same messages without stamps, check sums and checks, over iceoryx2 alone and over our ports.

use super::terms::{LOST, PATIENCE, null_plant};
use messages::port::{BarePort, ControllerPort, PlantPort, PortError, Waiting};
use messages::session::Session;
use messages::wire::{Command, Sensors, Stamp};
use sessions::open::open_with_timeout;
use shared::exit::{Exit, Failure};
use std::time::Instant;

/// Polls between two readings of the clock.
const POLLS: u32 = 1 << 12;

/// The plant's end.
pub enum BarePlant {
    /// iceoryx2 as its own examples use it.
    Bare(BarePort<Sensors, Command>),
    /// Our port, which reserves memory for messages in advance and releases it later.
    Ours(Box<PlantPort>),
}

/// The controller's end.
pub enum BareController {
    Bare(BarePort<Command, Sensors>),
    Ours(Box<ControllerPort>),
}

impl BarePlant {
    /// Joins a session.
    ///
    /// # Errors
    /// If the session cannot be made.
    pub fn open(session: &Session, ours: bool) -> Result<BarePlant, Failure> {
        let contract = null_plant();
        open_with_timeout(|| match ours {
            true => Ok(BarePlant::Ours(Box::new(PlantPort::open(session, &contract)?.waiting(Waiting::Spin)))),
            false => BarePort::plant(session, &contract).map(BarePlant::Bare),
        })
    }

    /// Sends sensors and waits for the answering command.
    ///
    /// # Errors
    /// A link that breaks, or no answer in time.
    #[inline]
    pub fn ask(&mut self, seq: u32) -> Result<(), Failure> {
        let stamp = Stamp { seq: seq.into(), ..Stamp::default() };
        self.send(Sensors { stamp, ..Sensors::default() })?;
        let mut poll = || match self {
            BarePlant::Bare(port) => port.poll(),
            BarePlant::Ours(port) => port.wait(),
        };
        while receive(&mut poll)?.stamp.ack != stamp.seq {}
        Ok(())
    }

    /// Announces the end.
    ///
    /// # Errors
    /// If the link breaks.
    pub fn end(&self) -> Result<(), Failure> {
        Ok(self.send(Sensors { last: 1, ..Sensors::default() })?)
    }

    #[inline]
    fn send(&self, sensors: Sensors) -> Result<(), PortError> {
        match self {
            BarePlant::Bare(port) => port.send(sensors),
            BarePlant::Ours(port) => port.send_raw(sensors),
        }
    }
}

impl BareController {
    /// Joins a session.
    ///
    /// # Errors
    /// If the session cannot be made.
    pub fn open(session: &Session, ours: bool) -> Result<BareController, Failure> {
        let contract = null_plant();
        open_with_timeout(|| match ours {
            true => {
                Ok(BareController::Ours(Box::new(ControllerPort::open(session, &contract)?.waiting(Waiting::Spin))))
            }
            false => BarePort::controller(session, &contract).map(BareController::Bare),
        })
    }

    /// Answers all sensors until the end.
    ///
    /// # Errors
    /// A link that breaks, or no question in time.
    pub fn serve(&mut self) -> Result<(), Failure> {
        loop {
            let mut poll = || match self {
                BareController::Bare(port) => port.poll(),
                BareController::Ours(port) => port.wait(),
            };
            let Sensors { stamp, last, .. } = receive(&mut poll)?;
            if last != 0 {
                return Ok(());
            }
            let command = Command { stamp: Stamp { ack: stamp.seq, ..stamp }, ..Command::default() };
            match self {
                BareController::Bare(port) => port.send(command)?,
                BareController::Ours(port) => port.send_raw(command)?,
            }
        }
    }
}

/// Polls until there is a message.
#[inline]
fn receive<M>(poll: &mut impl FnMut() -> Result<Option<M>, PortError>) -> Result<M, Failure> {
    let mut start = None;
    for polls in 1_u32.. {
        if let Some(message) = poll()? {
            return Ok(message);
        }
        std::hint::spin_loop();
        if polls % POLLS == 0 && start.get_or_insert_with(Instant::now).elapsed() > PATIENCE {
            break;
        }
    }
    Err(Failure::new(Exit::PeerMissing, LOST))
}
