//! iceoryx2 alone, as its own examples use it: what our messages cost without seal, check, stamp and wake-up. For measuring.

use super::contract::Contract;
use super::error::{PortError, broken};
use super::link::Reader;
use super::place::Place;
use super::{COMMAND, SENSORS};
use crate::session::Session;
use crate::wire::{Command, Sensors, Stamped};
use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::*;

/// One end of a link that adds nothing to iceoryx2.
#[derive(Debug)]
pub struct BarePort<Out: Stamped, In: Stamped> {
    writer: Publisher<ipc::Service, Out, ()>,
    reader: Reader<In>,
    _place: Place,
}

impl BarePort<Sensors, Command> {
    /// The plant's end.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn plant(session: &Session, contract: &Contract) -> Result<Self, PortError> {
        BarePort::open(session, contract, [SENSORS, COMMAND])
    }
}

impl BarePort<Command, Sensors> {
    /// The controller's end.
    ///
    /// # Errors
    /// See [`PortError`].
    pub fn controller(session: &Session, contract: &Contract) -> Result<Self, PortError> {
        BarePort::open(session, contract, [COMMAND, SENSORS])
    }
}

impl<Out: Stamped, In: Stamped> BarePort<Out, In> {
    fn open(session: &Session, contract: &Contract, [out, back]: [&str; 2]) -> Result<Self, PortError> {
        let place = Place::open(session, contract)?;
        let topic = place.link::<Out>(out)?;
        let writer = topic.publisher_builder().max_loaned_samples(1).create().map_err(|e| broken("writing", e))?;
        let reader = Reader::open(&place.link::<In>(back)?, 1)?;
        Ok(BarePort { writer, reader, _place: place })
    }

    /// Loan, copy, send.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn send(&self, message: Out) -> Result<(), PortError> {
        let sample = self.writer.loan_uninit().map_err(|e| broken("writing", e))?;
        sample.write_payload(message).send().map_err(|e| broken("writing", e))?;
        Ok(())
    }

    /// One look: a copy of the newest message, if there is one.
    ///
    /// # Errors
    /// [`PortError::SharedMemory`].
    #[inline]
    pub fn look(&self) -> Result<Option<In>, PortError> {
        self.reader.next()
    }
}
